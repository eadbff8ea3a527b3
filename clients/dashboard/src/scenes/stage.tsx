// A view of the scene that one moves about: the daemon renders each picture, small ones while it moves and better ones
// once it stands still.

import { useEffect, useRef, useState } from "preact/hooks";

import { askPatiently, withQuery } from "../api/client";
import { ByPointer } from "../ui/by_pointer";
import { secondsText } from "../ui/format";
import { NewestFirst } from "./newest_first";
import { dollied, lookedAbout, type Orbit, panned, turned } from "./orbit";
import { scenePath } from "./scene_path";
import { membersOf, type View } from "./view_url";

/** What a plain drag does. */
export const kDrags = { orbit: "Orbit", look: "Look about", pan: "Pan" } as const;
export type Drag = keyof typeof kDrags;

interface Quality {
  width: number;
  passes: number;
}
/** From the quickest, while the view moves, to the best, once it stands. */
const kQualities: Quality[] = [
  { width: 192, passes: 1 },
  { width: 512, passes: 2 },
  { width: 512, passes: 16 },
];
const kStillMs = 180;
const kLeastSide = 16;
/** Of a view whose camera asks for none. */
export const kAspect = 4 / 3;

interface Wish {
  view: View;
  quality: number;
}

/** A picture that has come, and by how many stops the daemon exposed it. */
interface Drawn {
  picture: Blob;
  exposure: number | null;
}

interface Shown {
  url: string;
  exposure: number | null;
  wish: Wish;
  milliseconds: number;
}

/** The longer side is the quality's. */
const sizeOf = (quality: Quality, aspect: number) => {
  const width = Math.round(quality.width * Math.min(1, aspect));
  return { width, height: Math.max(kLeastSide, Math.round(width / aspect)) };
};

const pathOf = (scene: string, { view, quality }: Wish, aspect: number): string => {
  const { passes } = kQualities[quality]!;
  return withQuery(`${scenePath(scene)}/preview.png`, { ...membersOf(view), ...sizeOf(kQualities[quality]!, aspect), passes });
};

async function draw(path: string, signal: AbortSignal, waits: () => boolean): Promise<Drawn> {
  const answer = await askPatiently(path, signal, waits);
  const said = answer.headers.get("X-Exposure-Stops");
  return { picture: await answer.blob(), exposure: said === null ? null : Number(said) };
}

interface Props {
  scene: string;
  view: View;
  /** The view as an orbit, to move from. */
  orbit: Orbit;
  radius: number;
  /** Width over height. */
  aspect: number;
  drag: Drag;
  /** The view one has moved to, while one moves. */
  onMove: (orbit: Orbit) => void;
  onHome: () => void;
  /** The exposure of the picture that is shown. */
  onExposure: (stops: number | null) => void;
}

/** The pictures of the view: a first one soon, better ones while it stands. */
function usePictures(scene: string, view: View, aspect: number): { shown: Shown | null; failure: Error | null } {
  const [shown, setShown] = useState<Shown | null>(null);
  const [failure, setFailure] = useState<Error | null>(null);
  const latest = useRef(view);
  const queue = useRef<NewestFirst<Wish, Drawn> | null>(null);
  useEffect(() => {
    let url: string | null = null;
    let timer = 0;
    const pictures: NewestFirst<Wish, Drawn> = new NewestFirst<Wish, Drawn>(
      (wish, signal) => draw(pathOf(scene, wish, aspect), signal, () => pictures.waits),
      ({ wish, answer, failure, milliseconds }) => {
        setFailure(failure ?? null);
        if (!answer) return;
        if (url) URL.revokeObjectURL(url);
        url = URL.createObjectURL(answer.picture);
        setShown({ url, exposure: answer.exposure, wish, milliseconds });
        if (pictures.waits || wish.view !== latest.current || wish.quality + 1 >= kQualities.length) return;
        clearTimeout(timer);
        timer = window.setTimeout(() => {
          if (wish.view === latest.current) pictures.want({ view: wish.view, quality: wish.quality + 1 });
        }, kStillMs);
      },
    );
    queue.current = pictures;
    return () => {
      pictures.stop();
      clearTimeout(timer);
      if (url) URL.revokeObjectURL(url);
      setShown(null);
    };
  }, [scene, aspect]);
  useEffect(() => {
    latest.current = view;
    queue.current?.want({ view, quality: 0 });
  }, [scene, view, aspect]);
  return { shown, failure };
}

const kKeyStep = 1 / 24;
const kDollyStep = 1.1;

/** What a key does to the view; null where it does nothing. */
function byKey(event: KeyboardEvent, orbit: Orbit, drag: Drag, radius: number): Orbit | null {
  const move = { orbit: turned, look: lookedAbout, pan: panned }[event.shiftKey ? "pan" : drag];
  switch (event.key) {
    case "ArrowLeft": return move(orbit, kKeyStep, 0);
    case "ArrowRight": return move(orbit, -kKeyStep, 0);
    case "ArrowUp": return move(orbit, 0, kKeyStep);
    case "ArrowDown": return move(orbit, 0, -kKeyStep);
    case "+": case "=": return dollied(orbit, 1 / kDollyStep, radius);
    case "-": return dollied(orbit, kDollyStep, radius);
    default: return null;
  }
}

export function Stage({ scene, view, orbit, radius, aspect, drag, onMove, onHome, onExposure }: Props) {
  const { shown, failure } = usePictures(scene, view, aspect);
  const exposure = shown?.exposure ?? null;
  useEffect(() => onExposure(exposure), [exposure]);
  const place = useRef<HTMLDivElement>(null);
  // Handlers that are set once see the newest of these.
  const now = useRef({ orbit, drag, onMove });
  now.current = { orbit, drag, onMove };
  const move = (next: Orbit) => {
    now.current.orbit = next; // two moves before a rendering must both count
    now.current.onMove(next);
  };
  useEffect(() => {
    const element = place.current!;
    const fingers = new Map<number, { x: number; y: number }>();
    const spread = () => {
      const [a, b] = [...fingers.values()];
      return a && b ? Math.hypot(a.x - b.x, a.y - b.y) : 0;
    };
    const down = (event: PointerEvent) => {
      if (event.button !== 0) return;
      fingers.set(event.pointerId, { x: event.clientX, y: event.clientY });
      element.setPointerCapture(event.pointerId);
    };
    const drags = (event: PointerEvent) => {
      const before = fingers.get(event.pointerId);
      if (!before) return;
      const wide = spread();
      const right = (event.clientX - before.x) / element.clientHeight, downwards = (event.clientY - before.y) / element.clientHeight;
      fingers.set(event.pointerId, { x: event.clientX, y: event.clientY });
      if (right === 0 && downwards === 0) return;
      const { orbit, drag } = now.current;
      if (fingers.size > 1) {
        // Of two fingers each moves the middle by half its way.
        if (wide > 0) move(panned(dollied(orbit, wide / Math.max(1, spread()), radius), right / fingers.size, downwards / fingers.size));
        return;
      }
      const kind = event.shiftKey ? "pan" : drag;
      move({ orbit: turned, look: lookedAbout, pan: panned }[kind](orbit, right, downwards));
    };
    const up = (event: PointerEvent) => fingers.delete(event.pointerId);
    const wheel = (event: WheelEvent) => {
      event.preventDefault();
      const lines = event.deltaMode === WheelEvent.DOM_DELTA_PIXEL ? event.deltaY / 100 : event.deltaY / 3;
      move(dollied(now.current.orbit, kDollyStep ** lines, radius));
    };
    element.addEventListener("pointerdown", down);
    element.addEventListener("pointermove", drags);
    element.addEventListener("pointerup", up);
    element.addEventListener("pointercancel", up);
    element.addEventListener("wheel", wheel, { passive: false });
    return () => {
      element.removeEventListener("pointerdown", down);
      element.removeEventListener("pointermove", drags);
      element.removeEventListener("pointerup", up);
      element.removeEventListener("pointercancel", up);
      element.removeEventListener("wheel", wheel);
    };
  }, [scene, radius]);
  const quality = shown ? kQualities[shown.wish.quality]! : null;
  const size = quality && sizeOf(quality, aspect);
  return (
    <div class="scene-stage">
      <div
        ref={place}
        class={`scene-picture${shown ? "" : " picture-frame waits"}`}
        role="application"
        aria-label="View of the scene"
        aria-describedby="scene-stage-keys"
        tabIndex={0}
        style={{ aspectRatio: String(aspect) }}
        onKeyDown={(event) => {
          if (event.ctrlKey || event.metaKey || event.altKey) return;
          if (event.key === "Home") onHome();
          else {
            const next = byKey(event, now.current.orbit, drag, radius);
            if (!next) return;
            move(next);
          }
          event.preventDefault();
        }}
      >
        {shown && <img src={shown.url} alt="" draggable={false} />}
        {shown && <span class="scene-preview-mark">Preview, filtered</span>}
        {failure && <p class="notice failed">No picture: {failure.message}</p>}
      </div>
      <p class="small muted scene-stage-line">
        <span id="scene-stage-keys">
          <ByPointer
            mouse="Drag or arrow keys to move, Shift to pan, wheel or + and − to come nearer, Home to begin again."
            finger="One finger moves the view, two fingers pan it, and a pinch comes nearer."
          />
        </span>
        <span data-testid="took">
          {shown && quality && size ? `${size.width} × ${size.height}, ${quality.passes === 1 ? "1 pass" : `${quality.passes} passes`} in ${secondsText(shown.milliseconds / 1000)}` : "Rendering …"}
        </span>
      </p>
    </div>
  );
}
