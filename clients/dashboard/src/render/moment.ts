// The moment that a request is about, of a scene that has animations. Without one the scene is as its file rests.

import type { JobRequest, Scene, SceneAnimation } from "../api/types";
import { withMember } from "./draft";

const kMembers = ["animation", "time", "shutter"];

/** The animation as the daemon takes it: a time or a shutter by itself is of the first. Null: none, at rest. */
export const animationOf = (request: JobRequest): string | number | null =>
  request.animation ?? (request.time || request.shutter ? 0 : null);

/** That one among the scene's; null where there is none such. */
export function knownAnimation(request: JobRequest, motion: SceneAnimation[]): SceneAnimation | null {
  const chosen = animationOf(request);
  return motion.find(({ index, name }) => chosen === index || chosen === name) ?? null;
}

/** How a request names it: by its name, where that is its alone. */
export function nameInRequest({ index, name }: SceneAnimation, motion: SceneAnimation[]): string | number {
  return name && motion.find((other) => other.name === name)?.index === index ? name : index;
}

/** A scene that moves, or a request that says so of one that is not known to. */
export const hasMoment = (request: JobRequest, scene: Scene | undefined): boolean =>
  (scene?.motion ?? []).length > 0 || animationOf(request) !== null;

export const atRest = (request: JobRequest): JobRequest => kMembers.reduce((changed, name) => withMember(changed, name, null), request);

/** The request about another animation, at the same time as far as that goes. */
export function withAnimation(request: JobRequest, animation: SceneAnimation, motion: SceneAnimation[]): JobRequest {
  const { time } = request;
  const kept = time ? Math.min(time, animation.duration_seconds) || null : time;
  return withMember(withMember(request, "animation", nameInRequest(animation, motion)), "time", kept);
}

/** With a time or a shutter. 0 is left out, but not the animation: its first moment need not be how the file rests. */
export function withMoment(request: JobRequest, name: "time" | "shutter", value: unknown): JobRequest {
  const moving = (request.animation ?? null) === null ? withMember(request, "animation", animationOf(request)) : request;
  return withMember(moving, name, value === 0 ? null : value);
}

/** Where a slider of an animation's time has been put, in round numbers and no later than its end. */
export function roundTime(time: number, duration: number): number {
  const digits = Math.max(0, 2 - Math.floor(Math.log10(duration)));
  return Math.min(duration, Number(time.toFixed(digits)));
}
