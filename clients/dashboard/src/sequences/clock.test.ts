import { expect, test } from "vitest";

import { frameAt, playSeconds, stepped } from "./clock";

const frames = [2, 2.1, 2.2, 2.3].map((time) => ({ time }));

test("a frame is shown from its moment on, and the last one stays", () => {
  expect([-1, 0, 0.05, 0.1, 0.19, 0.2, 0.35, 9].map((seconds) => frameAt(frames, seconds))).toEqual([0, 0, 0, 1, 1, 2, 3, 3]);
  expect(frameAt([], 1)).toBe(0);
});

test("a sequence plays until its last frame has been shown as long as the others", () => {
  expect(playSeconds(frames, 10)).toBeCloseTo(0.4);
  expect(playSeconds([], 10)).toBe(0);
});

test("steps go round", () => {
  expect(frameAt(frames, stepped(frames, 0, 1))).toBe(1);
  expect(frameAt(frames, stepped(frames, 0, -1))).toBe(3);
  expect(frameAt(frames, stepped(frames, 0.3, 1))).toBe(0);
  expect(stepped([], 0, 1)).toBe(0);
});
