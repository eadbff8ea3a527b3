// Settings of the images' jobs that change which light is in them: images that differ in one of these differ however long
// they are rendered.

import type { Job, Json } from "../api/types";
import { bouncesOf } from "../studies/bounces";

interface Setting {
  name: string;
  /** What the job has of it, as people read it; null where the job's method has no such setting. */
  of: (job: Job) => string | null;
}

const text = (value: unknown): string => (typeof value === "string" ? value : JSON.stringify(value));

const kSettings: Setting[] = [
  {
    name: "bounces of indirect light",
    of: ({ request }) => {
      const bounces = bouncesOf(request.method);
      return bounces === null ? null : bounces === Infinity ? "all" : String(bounces);
    },
  },
  { name: "the clamp of connections", of: ({ request }) => clampOf(request.method.parameters?.clamp, request.method.parameters?.repay) },
  { name: "the scene", of: ({ request }) => request.scene },
  { name: "the environment", of: ({ request }) => (request.environment ? text(request.environment) : "the scene’s own") },
  { name: "glass", of: ({ request }) => (request.glass === "solid" ? "solid" : "as the scene has it") },
  { name: "the moment", of: ({ request }) => momentText([request.animation ?? null, request.time ?? 0, request.shutter ?? 0]) },
];

/** What is clamped and found again by rays is no loss. */
function clampOf(clamp: Json | undefined, repay: Json | undefined): string | null {
  if (clamp === undefined) return null;
  if (repay === true || clamp === 0) return "nothing is lost";
  return clamp === null ? "by the lit area" : `${text(clamp)} m²`;
}

const momentText = ([animation, time, shutter]: unknown[]): string =>
  animation === null && time === 0 && shutter === 0 ? "at rest" : `${animation === null ? "" : `${text(animation)}, `}${text(time)} s${shutter ? `, open for ${text(shutter)} s` : ""}`;

/** A sentence for each setting in which some of the jobs differ; uploaded images say nothing of theirs. */
export function lightDifferences(jobs: readonly (Job | null)[]): string[] {
  return kSettings.flatMap(({ name, of }) => {
    const groups = new Map<string, number[]>();
    jobs.forEach((job, index) => {
      const value = job && of(job);
      if (value !== null) groups.set(value, [...(groups.get(value) ?? []), index + 1]);
    });
    if (groups.size < 2) return [];
    return [`${name}: ${[...groups].map(([value, numbers]) => `${value} in ${numbers.length === 1 ? "image" : "images"} ${numbers.join(", ")}`).join("; ")}`];
  });
}
