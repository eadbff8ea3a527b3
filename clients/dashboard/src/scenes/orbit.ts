// A view that goes about a point, upright: what dragging, the wheel and keys do to it.

import type { LookAt, Vec3 } from "../api/types";

export interface Orbit {
  target: Vec3;
  /** From target to eye, more than 0. */
  distance: number;
  /** Radians about +Y from +Z towards +X, as seen from the target. */
  azimuth: number;
  /** Radians above the horizon; never quite at a pole, where a view has no upright. */
  elevation: number;
  /** Vertical field of view, radians. */
  yfov: number;
}

export interface Bounds {
  min: Vec3;
  max: Vec3;
}

const kPole = (89 * Math.PI) / 180;
const kDefaultYfov = 0.69;
const kRadiansPerHeight = Math.PI; // a drag over the picture's height is half a turn

const add = (a: Vec3, b: Vec3, scale = 1): Vec3 => [a[0] + scale * b[0], a[1] + scale * b[1], a[2] + scale * b[2]];
const difference = (a: Vec3, b: Vec3): Vec3 => add(a, b, -1);
const clamp = (value: number, low: number, high: number) => Math.min(high, Math.max(low, value));

/** The unit vector from target to eye. */
function outward({ azimuth, elevation }: Orbit): Vec3 {
  const flat = Math.cos(elevation);
  return [flat * Math.sin(azimuth), Math.sin(elevation), flat * Math.cos(azimuth)];
}

const rightOf = ({ azimuth }: Orbit): Vec3 => [Math.cos(azimuth), 0, -Math.sin(azimuth)];

function upOf({ azimuth, elevation }: Orbit): Vec3 {
  const flat = -Math.sin(elevation);
  return [flat * Math.sin(azimuth), Math.cos(elevation), flat * Math.cos(azimuth)];
}

export const eyeOf = (orbit: Orbit): Vec3 => add(orbit.target, outward(orbit), orbit.distance);

/** The orbit that has this view; a view that is rolled is set upright. */
export function orbitOf({ eye, target, yfov }: LookAt): Orbit {
  const way = difference(eye, target);
  const distance = Math.hypot(...way);
  const there = distance > 0;
  return {
    target: there ? target : add(target, [0, 0, -1]),
    distance: there ? distance : 1,
    azimuth: there ? Math.atan2(way[0], way[2]) : 0,
    elevation: there ? clamp(Math.asin(way[1] / distance), -kPole, kPole) : 0,
    yfov: yfov ?? kDefaultYfov,
  };
}

export const lookAtOf = (orbit: Orbit): Required<LookAt> => ({
  eye: eyeOf(orbit),
  target: orbit.target,
  up: [0, 1, 0],
  yfov: orbit.yfov,
});

/** By a drag, in heights of the picture, right and down: the scene follows the hand. */
export function turned(orbit: Orbit, right: number, down: number): Orbit {
  return {
    ...orbit,
    azimuth: orbit.azimuth - right * kRadiansPerHeight,
    elevation: clamp(orbit.elevation + down * kRadiansPerHeight, -kPole, kPole),
  };
}

/** By a drag, with the eye where it is: to look about a room from within. */
export function lookedAbout(orbit: Orbit, right: number, down: number): Orbit {
  const eye = eyeOf(orbit);
  // What is seen follows the hand, so a height of the picture is its field of view.
  const next = {
    ...orbit,
    azimuth: orbit.azimuth + right * orbit.yfov,
    elevation: clamp(orbit.elevation - down * orbit.yfov, -kPole, kPole),
  };
  return { ...next, target: add(eye, outward(next), -next.distance) };
}

/** By a drag, sideways: what is at the target's distance stays under the hand. */
export function panned(orbit: Orbit, right: number, down: number): Orbit {
  const height = 2 * orbit.distance * Math.tan(orbit.yfov / 2);
  const target = add(add(orbit.target, rightOf(orbit), -right * height), upOf(orbit), down * height);
  return { ...orbit, target };
}

/** Nearer for factors below 1, farther above; within what the scene's size makes sense of. */
export function dollied(orbit: Orbit, factor: number, radius: number): Orbit {
  return { ...orbit, distance: clamp(orbit.distance * factor, radius / 1000, radius * 100) };
}

/** Half the diagonal; 1 for a scene of no extent. */
export function radiusOf(bounds: Bounds | null): number {
  if (!bounds) return 1;
  return Math.hypot(...difference(bounds.max, bounds.min)) / 2 || 1;
}

/** The same direction, so far off that all of the scene is in the picture. */
export function framed(orbit: Orbit, bounds: Bounds, aspect: number): Orbit {
  const half = orbit.yfov / 2;
  const narrower = aspect < 1 ? Math.atan(Math.tan(half) * aspect) : half;
  const center = add(bounds.min, difference(bounds.max, bounds.min), 0.5);
  return { ...orbit, target: center, distance: radiusOf(bounds) / Math.sin(narrower) };
}

/** Six digits are finer than a pixel, and short enough for an address. */
export const shortNumber = (value: number): number => Number(value.toPrecision(6)) || 0;
export const shortVector = (vector: Vec3): Vec3 => vector.map(shortNumber) as Vec3;
