import { withQuery } from "../api/client";
import type { Scene } from "../api/types";
import { Picture } from "../ui/picture";
import { scenePath } from "./scene_path";
import { kAspect } from "./stage";
import type { View } from "./view_url";

const degrees = (radians: number | null) => (radians === null ? "orthographic" : `${Math.round((radians * 180) / Math.PI)}° high`);

/** The scene's own cameras, to begin from. */
export function Cameras({ scene, view, onChoose }: { scene: Scene; view: View; onChoose: (name: string) => void }) {
  return (
    <section class="panel" aria-labelledby="scene-cameras">
      <h2 id="scene-cameras">Cameras</h2>
      {scene.cameras.length === 0 ? (
        <p class="muted">The file has none; the view above is framed on the whole scene.</p>
      ) : (
        <ul class="scene-cameras">
          {scene.cameras.map((camera) => (
            <li key={camera.name}>
              <button
                class="scene-camera"
                aria-pressed={"camera" in view && view.camera === camera.name}
                onClick={() => onChoose(camera.name)}
              >
                <Picture
                  path={withQuery(`${scenePath(scene)}/preview.png`, { camera: camera.name, width: 256, height: Math.round(256 / kAspect), passes: 4 })}
                  alt=""
                  ratio={kAspect}
                />
                <span>{camera.name}</span>
                <span class="small scene-camera-angle">{degrees(camera.yfov)}</span>
              </button>
            </li>
          ))}
        </ul>
      )}
    </section>
  );
}
