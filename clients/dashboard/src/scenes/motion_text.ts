import type { SceneAnimation } from "../api/types";
import { numberText } from "../ui/format";

/** How long an animation takes and what it moves: "4 s, moves 4 meshes, 1 camera". */
export function motionText({ duration_seconds, moves }: SceneAnimation): string {
  const parts = (Object.entries({ mesh: moves.meshes, camera: moves.cameras, light: moves.lights, material: moves.materials }) as [string, number][])
    .filter(([, number]) => number > 0)
    .map(([what, number]) => `${number} ${what}${number === 1 ? "" : what === "mesh" ? "es" : "s"}`);
  return `${numberText(duration_seconds)} s, moves ${parts.join(", ") || "nothing that is rendered"}`;
}
