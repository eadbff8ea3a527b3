import { describe, expect, it } from "vitest";

import { aspectText, boundedAspect, kFirstPixels, kPixelChoices, sizeOfAspect } from "./aspect";

describe("sizes by shape", () => {
  it("have the shape, and about the number of pixels", () => {
    for (const aspect of [1, 4 / 3, 16 / 9, 2.35, 9 / 16, 1 / 3])
      for (const pixels of kPixelChoices) {
        const { width, height } = sizeOfAspect(aspect, pixels);
        expect(Math.abs(width / height / aspect - 1)).toBeLessThan(0.012);
        expect(Math.abs((width * height) / pixels - 1)).toBeLessThan(0.08);
      }
  });
  it("are the usual ones where the shape is", () => {
    expect(sizeOfAspect(1, kFirstPixels)).toEqual({ width: 512, height: 512 });
    expect(sizeOfAspect(16 / 9, 1920 * 1080)).toEqual({ width: 1920, height: 1080 });
    expect(sizeOfAspect(16 / 9, 1280 * 720)).toEqual({ width: 1280, height: 720 });
    expect(sizeOfAspect(4 / 3, kFirstPixels)).toEqual({ width: 592, height: 444 });
  });
  it("are never of no height", () => {
    expect(sizeOfAspect(1e4, 64).height).toBeGreaterThanOrEqual(1);
    expect([boundedAspect(1e9), boundedAspect(0)]).toEqual([8, 0.125]);
  });
});

describe("shapes", () => {
  it("have the names that people know", () => {
    expect([1, 4 / 3, 592 / 444, 16 / 9, 2.35, 0.5625, 0.3].map(aspectText)).toEqual(["1:1", "4:3", "4:3", "16:9", "2.35:1", "9:16", "1:3.33"]);
  });
});
