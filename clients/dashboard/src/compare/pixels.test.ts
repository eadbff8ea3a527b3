import { describe, expect, it } from "vitest";

import { pixelAt, pixelImage } from "./pixels";

// 1, 2, NaN | 0.5, infinity, -1 as halves.
const halves = new Uint16Array([0x3c00, 0x4000, 0x7e00, 0x3800, 0x7c00, 0xbc00]);

describe("an image's values", () => {
  it("counts pixels that are not finite, and leaves them out of the rest", () => {
    expect(pixelImage(2, 1, 3, halves).statistics).toEqual({ mean: 2.5 / 4, low: -1, high: 2, nans: 1, infinities: 1, infinite: [{ index: 1, negative: false }] });
    expect(pixelImage(3, 2, 1, halves).statistics).toEqual({ mean: 2.5 / 4, low: -1, high: 2, nans: 1, infinities: 1, infinite: [{ index: 4, negative: false }] });
    expect(pixelImage(1, 1, 1, new Float32Array([NaN])).statistics).toEqual({ mean: null, low: null, high: null, nans: 1, infinities: 0, infinite: [] });
  });
  it("lists infinite pixels by their sign, but none that NaN stands for", () => {
    const values = new Float32Array([-Infinity, 0, -Infinity, Infinity, NaN, Infinity]);
    expect(pixelImage(1, 3, 2, values).statistics).toMatchObject({ infinities: 3, infinite: [{ index: 0, negative: true }, { index: 1, negative: false }] });
  });
  it("reads the pixel at a place, row 0 at the top", () => {
    const image = pixelImage(1, 2, 3, halves);
    expect(pixelAt(image, 0, 0)).toEqual([1, 2, NaN]);
    expect(pixelAt(image, 0, 1)).toEqual([0.5, Infinity, -1]);
    expect(pixelAt(image, 1, 0)).toBeNull();
    expect(pixelAt(image, 0, -1)).toBeNull();
    expect(pixelAt(pixelImage(2, 1, 1, new Float32Array([70000, 0.1])), 0, 0)).toEqual([70000]);
  });
  it("does not take values that are not all there", () => {
    expect(() => pixelImage(2, 2, 3, halves)).toThrow("6 values for 2 × 2 pixels of 3 channels");
  });
});
