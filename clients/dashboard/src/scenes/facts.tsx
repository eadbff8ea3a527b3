// What is in a scene, and what that asks of whoever renders it.

import type { ComponentChildren } from "preact";

import type { Scene, Vec3 } from "../api/types";
import { bytesText, numberText } from "../ui/format";
import { motionText } from "./motion_text";
import { needsOf } from "./needs";

const count = (value: number | null) => (value === null ? "–" : value.toLocaleString("en"));
const extent = ({ min, max }: { min: Vec3; max: Vec3 }) => max.map((value, k) => numberText(value - min[k]!)).join(" × ");

function lightsText({ lights }: Scene): string {
  if (!lights) return "–";
  const parts = [
    ...(lights.area > 0 ? [`${count(lights.area)} glowing triangles`] : []),
    ...(lights.punctual > 0 ? [`${count(lights.punctual)} points, spots or suns`] : []),
    ...(lights.environment ? ["light from all around"] : []),
  ];
  return parts.join(", ") || "none: its pictures here are under a white sky";
}

function Fact({ name, children }: { name: string; children: ComponentChildren }) {
  return (
    <>
      <dt>{name}</dt>
      <dd>{children}</dd>
    </>
  );
}

export function SceneFacts({ scene }: { scene: Scene }) {
  const needs = needsOf(scene.needs);
  return (
    <>
      {scene.warnings.length > 0 && (
        <section class="notice" aria-labelledby="scene-warnings">
          <h2 id="scene-warnings">Warnings</h2>
          <ul>
            {scene.warnings.map((warning) => (
              <li key={warning}>{warning}</li>
            ))}
          </ul>
        </section>
      )}
      {scene.known_answer && (
        <section class="panel" aria-labelledby="scene-answer">
          <h2 id="scene-answer">A hard case</h2>
          <p>It strains {scene.known_answer.strains}.</p>
          <p>What must come out: {scene.known_answer.text}</p>
        </section>
      )}
      <section class="panel" aria-labelledby="scene-facts">
        <h2 id="scene-facts">What is in it</h2>
        <dl class="facts">
          <Fact name="Triangles">{count(scene.triangles)}</Fact>
          <Fact name="Vertices">{count(scene.vertices)}</Fact>
          <Fact name="Lights">{lightsText(scene)}</Fact>
          <Fact name="Materials">{count(scene.materials)}</Fact>
          <Fact name="Textures">{count(scene.textures)}</Fact>
          {scene.bounds && <Fact name="Size">{extent(scene.bounds)} m</Fact>}
          {(scene.motion ?? []).map((animation) => (
            <Fact key={animation.index} name={animation.name || `Animation ${animation.index}`}>
              {motionText(animation)}
            </Fact>
          ))}
          <Fact name="Files">{scene.builtin ? "built in" : bytesText(scene.bytes)}</Fact>
          {scene.memory_bytes !== null && <Fact name="Memory">{bytesText(scene.memory_bytes)} in a worker</Fact>}
          {!scene.builtin && (
            <Fact name="Id">
              <code>{scene.id}</code>
            </Fact>
          )}
        </dl>
      </section>
      {needs.length > 0 && (
        <section class="panel" aria-labelledby="scene-needs">
          <h2 id="scene-needs">What a method must cope with</h2>
          <ul class="scene-needs">
            {needs.map((need) => (
              <li key={need.text}>
                {need.text}
                {need.means && <span class="muted">: {need.means}</span>}
              </li>
            ))}
          </ul>
        </section>
      )}
    </>
  );
}
