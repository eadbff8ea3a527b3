// A view in an address: `camera=NAME`, or `eye=x,y,z&target=x,y,z&yfov=r`, as the form of a job reads it too.

import type { LookAt, Vec3 } from "../api/types";
import { lookAtOf, type Orbit, orbitOf, shortNumber, shortVector } from "./orbit";

/** By a camera of the scene exactly, or by where one has gone from there. */
export type View = { camera: string } | { orbit: Orbit };

function vectorIn(text: string | undefined): Vec3 | null {
  const parts = (text ?? "").split(",").map((part) => (part.trim() === "" ? Number.NaN : Number(part)));
  return parts.length === 3 && parts.every(Number.isFinite) ? (parts as Vec3) : null;
}

/** The view an address asks for; null where it names none, or none that can be. */
export function viewIn(query: Record<string, string>): View | null {
  const eye = vectorIn(query.eye), target = vectorIn(query.target);
  if (eye && target && eye.some((value, k) => value !== target[k])) {
    const yfov = Number(query.yfov);
    return { orbit: orbitOf({ eye, target, ...(yfov > 0 && yfov < Math.PI ? { yfov } : {}) }) };
  }
  return query.camera ? { camera: query.camera } : null;
}

type Members = Record<"camera" | "eye" | "target" | "yfov", string | null>;

/** The members of an address for a view; null for those it does not have. */
export function membersOf(view: View): Members {
  if ("camera" in view) return { camera: view.camera, eye: null, target: null, yfov: null };
  const { eye, target, yfov } = lookAtOf(view.orbit);
  return { camera: null, eye: shortVector(eye).join(","), target: shortVector(target).join(","), yfov: String(shortNumber(yfov)) };
}

/** What a job's `camera` is for the view. */
export function jobCameraOf(view: View): { name: string } | { look_at: LookAt } {
  if ("camera" in view) return { name: view.camera };
  const { eye, target, up, yfov } = lookAtOf(view.orbit);
  return { look_at: { eye: shortVector(eye), target: shortVector(target), up, yfov: shortNumber(yfov) } };
}

/** The camera that an address of a form asks for, as a job takes it; null where it names none. */
export function cameraIn(query: Record<string, string>): ReturnType<typeof jobCameraOf> | null {
  const view = viewIn(query);
  return view && jobCameraOf(view);
}
