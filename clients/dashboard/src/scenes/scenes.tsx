// All scenes: those that are always there, and those one has brought.

import { useRef } from "preact/hooks";

import { useKeys } from "../app/keyboard";
import { Title } from "../app/title";
import { useQuery } from "../app/url_state";
import type { Scene } from "../api/types";
import { ByPointer } from "../ui/by_pointer";
import { Picture } from "../ui/picture";
import { useAllScenes } from "./all_scenes";
import { chosenFiles, useDrop } from "./dropping";
import { factsText, found, isOrder, kOrders, ordered } from "./gallery";
import { scenePage, scenePath } from "./scene_path";
import { UploadList } from "./upload_list";
import { arrivals, sendAll } from "./uploads";
import "./scenes.css";

const kFamilies = [
  { family: "", text: "Scenes" },
  { family: "hard-cases", text: "Hard cases" },
  { family: "photon-splatting", text: "Photon splatting's figures" },
  { family: "details", text: "Details of rooms" },
  { family: "caustics", text: "Caustics" },
  { family: "progressive", text: "Progressive photon mapping" },
  { family: "small-vcm", text: "SmallVCM's boxes" },
  { family: "doors", text: "Doors" },
  { family: "visibility-filtering", text: "Visibility filtering" },
  { family: "real-time", text: "In real time" },
  { family: "moving", text: "Moving" },
];
const kKinds = (
  <>
    a <code>.glb</code>, a <code>.zip</code>, or a <code>.gltf</code> with its files
  </>
);
const kWaiting = [0, 1, 2, 3, 4, 5, 6, 7];

function Card({ scene }: { scene: Scene }) {
  return (
    <li>
      <a class="scenes-card panel" href={scenePage(scene)}>
        <Picture path={`${scenePath(scene)}/thumbnail.png`} alt="" ratio={4 / 3} />
        <span class="scenes-card-text">
          <strong>{scene.name}</strong>
          <span class="muted small">{factsText(scene)}</span>
          {!scene.builtin && <span class="small muted">uploaded</span>}
          {scene.warnings.length > 0 && (
            <span class="small scenes-warned">{scene.warnings.length === 1 ? "1 warning" : `${scene.warnings.length} warnings`}</span>
          )}
        </span>
      </a>
    </li>
  );
}

function Choose({ text, folder = false }: { text: string; folder?: boolean }) {
  const input = useRef<HTMLInputElement>(null);
  return (
    <>
      <button class={folder ? "" : "primary"} onClick={() => input.current!.click()}>
        {text}
      </button>
      <input
        ref={input}
        class="visually-hidden"
        type="file"
        multiple
        tabIndex={-1}
        aria-label={text}
        {...(folder ? { webkitdirectory: true } : { accept: ".glb,.gltf,.zip,.bin,image/*" })}
        onChange={(event) => {
          void sendAll(chosenFiles(event.currentTarget.files));
          event.currentTarget.value = ""; // so that the same file may be chosen again
        }}
      />
    </>
  );
}

export function Scenes() {
  const [query, change] = useQuery();
  const family = query.family ?? "";
  const order = isOrder(query.sort) ? query.sort : "listed";
  const search = useRef<HTMLInputElement>(null);
  const { scenes, loading, failure } = useAllScenes(family, arrivals.value);
  const shown = ordered(found(scenes, query.q ?? ""), order);
  const hovering = useDrop((files) => void sendAll(files));
  useKeys("Scenes", [{ key: "/", text: "search", run: () => search.current?.focus() }], []);
  return (
    <div class="scenes">
      <Title text="Scenes">
        <Choose text="Upload a scene" />
        <Choose text="Upload a folder" folder />
      </Title>
      <p class="muted">
        <ByPointer
          mouse={<>Drop {kKinds} anywhere on this page.</>}
          finger={<>A scene is {kKinds}.</>}
        />
      </p>
      <UploadList />
      <div class="scenes-tools">
        <nav class="scenes-families" aria-label="Families of scenes">
          {kFamilies.map((one) => (
            <a key={one.family} href={one.family ? `/scenes?family=${one.family}` : "/scenes"} aria-current={one.family === family ? "page" : undefined}>
              {one.text}
            </a>
          ))}
        </nav>
        <label>
          <span class="visually-hidden">Search</span>
          <input
            ref={search}
            type="search"
            placeholder="Search …"
            value={query.q ?? ""}
            onInput={(event) => change({ q: event.currentTarget.value })}
          />
        </label>
        <label>
          <span class="visually-hidden">Order</span>
          <select value={order} onChange={(event) => change({ sort: event.currentTarget.value === "listed" ? null : event.currentTarget.value })}>
            {Object.entries(kOrders).map(([value, text]) => (
              <option key={value} value={value}>
                {text}
              </option>
            ))}
          </select>
        </label>
        <span class="muted small" role="status">
          {loading ? "Reading scenes …" : `${shown.length === scenes.length ? "" : `${shown.length} of `}${scenes.length} scenes`}
        </span>
      </div>
      {failure && (
        <p class="notice failed" role="alert">
          The scenes cannot be listed: {failure.message}. <button onClick={() => ++arrivals.value}>Try again</button>
        </p>
      )}
      {!loading && !failure && shown.length === 0 && <p class="empty">{query.q ? `No scene has “${query.q}” in its name.` : "There are no scenes here."}</p>}
      <ul class="scenes-gallery">
        {shown.map((scene) => (
          <Card key={scene.id} scene={scene} />
        ))}
        {loading &&
          shown.length < kWaiting.length &&
          kWaiting.slice(shown.length).map((place) => (
            <li key={`waits ${place}`} class="scenes-card panel scenes-waits" aria-hidden="true">
              <span class="picture-frame waits scenes-waits-picture" />
            </li>
          ))}
      </ul>
      {hovering && (
        <div class="scenes-drop" role="status">
          <strong>Drop it to upload it</strong>
          <span>.glb, .zip, or .gltf with its files or folder</span>
        </div>
      )}
    </div>
  );
}
