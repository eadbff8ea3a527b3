import { describe, expect, it } from "vitest";

import type { Vec3 } from "../api/types";
import { dollied, eyeOf, framed, lookAtOf, lookedAbout, type Orbit, orbitOf, panned, radiusOf, shortVector, turned } from "./orbit";

const close = (a: Vec3, b: Vec3) => a.forEach((value, k) => expect(value).toBeCloseTo(b[k]!, 9));
const ahead: Orbit = { target: [0, 0, 0], distance: 5, azimuth: 0, elevation: 0, yfov: 0.8 };

/** Where a point is in the picture, in heights from its middle, right and down; by a look-at of its own. */
function seenAt(orbit: Orbit, point: Vec3): [number, number, number] {
  const { eye, target, yfov } = lookAtOf(orbit);
  const minus = (a: Vec3, b: Vec3): Vec3 => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
  const cross = (a: Vec3, b: Vec3): Vec3 => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
  const dot = (a: Vec3, b: Vec3) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  const unit = (a: Vec3): Vec3 => a.map((value) => value / Math.hypot(...a)) as Vec3;
  const forward = unit(minus(target, eye));
  const right = unit(cross(forward, [0, 1, 0]));
  const up = cross(right, forward);
  const way = minus(point, eye);
  const depth = dot(way, forward);
  const height = 2 * depth * Math.tan(yfov / 2);
  return [dot(way, right) / height, -dot(way, up) / height, depth];
}

describe("an orbit and a look-at", () => {
  it("are the same view", () => {
    const eye: Vec3 = [3, 2, -4], target: Vec3 = [0.5, 1, 0.25];
    const orbit = orbitOf({ eye, target, yfov: 0.69 });
    close(eyeOf(orbit), eye);
    close(orbit.target, target);
    expect(lookAtOf(orbit)).toMatchObject({ up: [0, 1, 0], yfov: 0.69 });
  });
  it("know which way is +Z and +X", () => {
    expect(orbitOf({ eye: [0, 0, 5], target: [0, 0, 0] }).azimuth).toBe(0);
    expect(orbitOf({ eye: [5, 0, 0], target: [0, 0, 0] }).azimuth).toBeCloseTo(Math.PI / 2, 12);
  });
  it("stay off the poles", () => {
    const above = orbitOf({ eye: [0, 5, 0], target: [0, 0, 0] });
    expect(above.elevation).toBeLessThan(Math.PI / 2);
    expect(turned(above, 0, 10).elevation).toBeCloseTo((89 * Math.PI) / 180, 12);
    expect(turned(above, 0, -10).elevation).toBeCloseTo((-89 * Math.PI) / 180, 12);
  });
  it("have a direction even where eye and target are one point", () => {
    const orbit = orbitOf({ eye: [1, 1, 1], target: [1, 1, 1], yfov: 1 });
    close(eyeOf(orbit), [1, 1, 1]);
    expect(orbit.distance).toBe(1);
  });
});

describe("dragging", () => {
  it("to the right brings the scene's front to the right, keeping distance and height", () => {
    const next = turned(ahead, 0.1, 0);
    expect(seenAt(next, [0, 0, 1])[0]).toBeGreaterThan(0);
    expect(Math.hypot(...eyeOf(next))).toBeCloseTo(5, 12);
    expect(eyeOf(next)[1]).toBeCloseTo(0, 12);
  });
  it("down brings the scene's front down, seen from above", () => {
    const next = turned(ahead, 0, 0.1);
    expect(eyeOf(next)[1]).toBeGreaterThan(0);
    expect(seenAt(next, [0, 0, 1])[1]).toBeGreaterThan(0);
  });
  it("with pan keeps the target's plane under the hand", () => {
    const slanted = { ...ahead, azimuth: 0.7, elevation: 0.4 };
    const [x, y, depth] = seenAt(panned(slanted, 0.25, -0.1), slanted.target);
    expect([x, y, depth].map((value) => Number(value.toFixed(9)))).toEqual([0.25, -0.1, 5]);
  });
  it("when looking about keeps the eye, and what is seen follows the hand", () => {
    const slanted = { ...ahead, azimuth: 0.7, elevation: 0.2 };
    const next = lookedAbout(slanted, 0.1, 0.05);
    close(eyeOf(next), eyeOf(slanted));
    const [x, y] = seenAt(next, slanted.target);
    expect(x).toBeGreaterThan(0.05);
    expect(y).toBeGreaterThan(0.02);
  });
});

describe("distance", () => {
  it("is kept within what the scene's size makes sense of", () => {
    expect(dollied(ahead, 0.5, 1).distance).toBe(2.5);
    expect(dollied(ahead, 1e-9, 1).distance).toBe(0.001);
    expect(dollied(ahead, 1e9, 2).distance).toBe(200);
  });
  it("of the whole scene shows every corner, in pictures of either shape", () => {
    const bounds = { min: [-1, 0, -2] as Vec3, max: [3, 2.5, 2] as Vec3 };
    for (const aspect of [0.5, 1, 16 / 9]) {
      const view = framed({ ...ahead, azimuth: 0.6, elevation: 0.5 }, bounds, aspect);
      for (let corner = 0; corner < 8; ++corner) {
        const point = [0, 1, 2].map((k) => (corner & (1 << k) ? bounds.max : bounds.min)[k]) as Vec3;
        const [x, y, depth] = seenAt(view, point);
        expect(depth).toBeGreaterThan(0);
        expect(Math.abs(x)).toBeLessThan(aspect / 2);
        expect(Math.abs(y)).toBeLessThan(0.5);
      }
    }
    expect(radiusOf(bounds)).toBeCloseTo(Math.hypot(4, 2.5, 4) / 2, 12);
    expect(radiusOf({ min: [1, 1, 1], max: [1, 1, 1] })).toBe(1);
    expect(radiusOf(null)).toBe(1);
  });
});

it("writes numbers short", () => {
  expect(shortVector([1 / 3, -0, 123456789])).toEqual([0.333333, 0, 123457000]);
});
