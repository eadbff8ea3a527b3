import { describe, expect, it } from "vitest";

import type { Scene, SceneAnimation } from "../api/types";
import { kFirstRequest } from "./draft";
import { animationOf, atRest, hasMoment, knownAnimation, nameInRequest, roundTime, withAnimation, withMoment } from "./moment";

const motion = ["walk", "", "walk"].map((name, index) => ({ index, name, duration_seconds: index + 1 })) as SceneAnimation[];
const [walk, nameless, again] = motion as [SceneAnimation, SceneAnimation, SceneAnimation];

describe("the moment a request is about", () => {
  it("is of none, of one by its name or index, or of the first by a time or shutter alone", () => {
    expect(animationOf(kFirstRequest)).toBe(null);
    expect(animationOf({ ...kFirstRequest, animation: null, time: 0, shutter: 0 })).toBe(null);
    expect(animationOf({ ...kFirstRequest, time: 1 })).toBe(0);
    expect(animationOf({ ...kFirstRequest, shutter: 0.1 })).toBe(0);
    expect(knownAnimation({ ...kFirstRequest, animation: "walk" }, motion)).toBe(walk);
    expect(knownAnimation({ ...kFirstRequest, animation: 2 }, motion)).toBe(again);
    expect(knownAnimation({ ...kFirstRequest, animation: "run" }, motion)).toBe(null);
    expect(knownAnimation(kFirstRequest, motion)).toBe(null);
  });
  it("names an animation so that no other is meant", () => {
    expect(motion.map((animation) => nameInRequest(animation, motion))).toEqual(["walk", 1, 2]);
  });
  it("is written down as briefly as it can be", () => {
    const walking = withAnimation(kFirstRequest, walk, motion);
    expect(walking).toEqual({ ...kFirstRequest, animation: "walk" });
    const later = withMoment(withMoment(walking, "time", 0.5), "shutter", 0.02);
    expect(later).toEqual({ ...kFirstRequest, animation: "walk", time: 0.5, shutter: 0.02 });
    expect(withMoment(withMoment(later, "time", 0), "shutter", null)).toEqual(walking);
    expect(withMoment(walking, "time", "soon")).toMatchObject({ time: "soon" }); // for the daemon to name
    expect(atRest(later)).toEqual(kFirstRequest);
  });
  it("stays in its animation where the time comes to 0", () => {
    expect(withMoment({ ...kFirstRequest, time: 1 }, "time", 0)).toEqual({ ...kFirstRequest, animation: 0 });
  });
  it("is no later than another animation's end", () => {
    expect(withAnimation({ ...kFirstRequest, animation: 2, time: 2.5 }, nameless, motion)).toMatchObject({ animation: 1, time: 2 });
    expect(withAnimation({ ...kFirstRequest, time: 0.5 }, again, motion)).toMatchObject({ animation: 2, time: 0.5 });
  });
  it("is asked for where something moves, or is said to", () => {
    expect(hasMoment(kFirstRequest, undefined)).toBe(false);
    expect(hasMoment(kFirstRequest, { motion: [] } as unknown as Scene)).toBe(false);
    expect(hasMoment(kFirstRequest, { motion: null } as Scene)).toBe(false);
    expect(hasMoment(kFirstRequest, { motion } as Scene)).toBe(true);
    expect(hasMoment({ ...kFirstRequest, time: 1 }, undefined)).toBe(true);
  });
  it("is a round number by the slider, and never after the end", () => {
    expect(roundTime(1.23456, 4)).toBe(1.23);
    expect(roundTime(0.123456, 0.5)).toBe(0.123);
    expect(roundTime(12.3456, 24)).toBe(12.3);
    expect(roundTime(123.456, 1000)).toBe(123);
    expect(roundTime(1.0416667, 1.0416667)).toBe(1.04);
    expect(roundTime(1.0466667, 1.0466667)).toBe(1.0466667);
  });
});
