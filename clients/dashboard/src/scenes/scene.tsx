// One scene: seen from wherever one likes, and what is in it.

import { useEffect, useRef, useState } from "preact/hooks";
import { useLocation, useRoute } from "preact-iso";

import { Problem, withQuery } from "../api/client";
import { Title } from "../app/title";
import { useQuery } from "../app/url_state";
import type { Scene } from "../api/types";
import { useRemote } from "../ui/remote";
import { say } from "../ui/toasts";
import { Cameras } from "./cameras";
import { DeleteScene } from "./delete_scene";
import { SceneFacts } from "./facts";
import { boundedAspect, kFirstPixels, sizeOfAspect } from "../ui/aspect";
import { framed, type Orbit, orbitOf, radiusOf } from "./orbit";
import { scenePath } from "./scene_path";
import { type Drag, kAspect, kDrags, Stage } from "./stage";
import { jobCameraOf, membersOf, type View, viewIn } from "./view_url";
import "./scene.css";

/** A view at rest is in the address; while it moves, that would only fill the history. */
const kRestMs = 250;

/** Where the picture begins when the address does not say. */
const homeOf = (scene: Scene): View => (scene.cameras[0] ? { camera: scene.cameras[0].name } : { orbit: orbitOf(scene.default_view) });

/** The view as an orbit to move from: of a camera by what it looks at. */
function orbitFrom(scene: Scene, view: View): Orbit {
  if ("orbit" in view) return view.orbit;
  const camera = scene.cameras.find(({ name }) => name === view.camera);
  return orbitOf(camera?.look_at ?? scene.default_view);
}

/** The shape of the image that the view's camera asks for. */
const aspectOf = (scene: Scene, view: View): number => {
  const camera = "camera" in view ? scene.cameras.find(({ name }) => name === view.camera) : scene.cameras[0];
  return boundedAspect(camera?.aspect ?? kAspect);
};

type Members = ReturnType<typeof membersOf>;
const textOf = (members: Partial<Members>): string => [members.camera, members.eye, members.target, members.yfov].map((text) => text ?? "").join(" ");

/** The view shown, which the address holds once it is at rest; and how to step to another or move on from it. */
function useView(scene: Scene) {
  const [query, change] = useQuery();
  const [view, setView] = useState<View>(() => viewIn(query) ?? homeOf(scene));
  const address = textOf(query);
  const written = useRef(address);
  const timer = useRef(0);
  useEffect(() => () => clearTimeout(timer.current), []);
  // What the back button brings is shown; what was written here is shown already.
  useEffect(() => {
    if (address === written.current) return;
    written.current = address;
    clearTimeout(timer.current);
    setView(viewIn(query) ?? homeOf(scene));
  }, [address]);
  const write = (next: View, step: boolean) => {
    const members = membersOf(next);
    written.current = textOf(members);
    change(members, step);
  };
  const show = (next: View) => {
    clearTimeout(timer.current);
    setView(next);
    write(next, true);
  };
  const move = (orbit: Orbit) => {
    const next = { orbit };
    setView(next);
    clearTimeout(timer.current);
    timer.current = window.setTimeout(() => write(next, false), kRestMs);
  };
  return { view, show, move };
}

function Room({ scene }: { scene: Scene }) {
  const { view, show, move } = useView(scene);
  const [query, change] = useQuery();
  const drag: Drag = query.drag === "look" || query.drag === "pan" ? query.drag : "orbit";
  const orbit = orbitFrom(scene, view);
  const known = !("camera" in view) || scene.cameras.some(({ name }) => name === view.camera);
  const members = membersOf(view);
  const [exposure, setExposure] = useState<number | null>(null);
  const aspect = aspectOf(scene, view);
  // What is rendered from here has the shape of this picture, and is shown by its exposure.
  const render = { scene: scene.id, ...members, ...sizeOfAspect(aspect, kFirstPixels), ...(exposure === null ? {} : { exposure, curve: "filmic" }) };
  const copy = async () => {
    const camera = jobCameraOf(view);
    await navigator.clipboard.writeText(JSON.stringify(camera, null, 2));
    say("The camera is copied, as a job's “camera” takes it.");
  };
  return (
    <div class="scene-room">
      <section class="panel" aria-label="View">
        <div class="scene-tools">
          <div class="row" role="group" aria-label="What a drag does">
            {Object.entries(kDrags).map(([value, text]) => (
              <button key={value} aria-pressed={drag === value} onClick={() => change({ drag: value === "orbit" ? null : value })}>
                {text}
              </button>
            ))}
          </div>
          <div class="row">
            {scene.bounds && <button onClick={() => show({ orbit: framed(orbit, scene.bounds!, aspect) })}>Show all</button>}
            <button onClick={() => show(homeOf(scene))}>Reset</button>
            <button onClick={() => void copy()} title="As JSON, for a job's camera">
              Copy camera
            </button>
          </div>
        </div>
        {known ? (
          <Stage scene={scene.id} view={view} orbit={orbit} radius={radiusOf(scene.bounds)} aspect={aspect} drag={drag} onMove={move} onHome={() => show(homeOf(scene))} onExposure={setExposure} />
        ) : (
          <p class="notice failed">
            The scene has no camera {"camera" in view && `“${view.camera}”`}. <button onClick={() => show(homeOf(scene))}>Show its own view</button>
          </p>
        )}
        <div class="row scene-go">
          <a class="button primary" href={withQuery("/render", render)} title="By this view, in this shape, and shown by this exposure">
            Render from here
          </a>
          <a class="button" href={withQuery("/studies/new", { scene: scene.id, ...members })}>
            Compare methods here
          </a>
        </div>
      </section>
      <div class="stack">
        <Cameras scene={scene} view={view} onChoose={(name) => show({ camera: name })} />
        <SceneFacts scene={scene} />
      </div>
    </div>
  );
}

export function ScenePage() {
  const { params } = useRoute();
  const { route } = useLocation();
  const name = params.scene ?? "";
  const { data: scene, failure, loading, reload } = useRemote<Scene>(scenePath(name));
  const [deleting, setDeleting] = useState(false);
  const title = scene?.name ?? name;
  if (failure && !scene) {
    const unknown = failure instanceof Problem && failure.status === 404;
    return (
      <>
        <Title text={unknown ? "No such scene" : title} />
        <p class="notice failed" role="alert">
          {failure.message}. {unknown ? <a href="/scenes">All scenes</a> : <button onClick={reload}>Try again</button>}
        </p>
      </>
    );
  }
  return (
    <>
      <Title text={title}>
        <a href={scene?.builtin && scene.id.includes("/") ? `/scenes?family=${scene.id.split("/")[0]}` : "/scenes"}>All scenes</a>
        {scene && !scene.builtin && (
          <button class="danger" onClick={() => setDeleting(true)}>
            Delete …
          </button>
        )}
      </Title>
      {scene ? <Room key={scene.id} scene={scene} /> : loading && <p class="empty">The daemon reads the scene …</p>}
      {scene && deleting && (
        <DeleteScene
          scene={scene}
          onClose={() => setDeleting(false)}
          onDeleted={() => {
            say(`${scene.name} is deleted.`);
            route("/scenes");
          }}
        />
      )}
    </>
  );
}
