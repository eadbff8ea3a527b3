import { describe, expect, it } from "vitest";

import { colourAt, colourMap, srgbEncode } from "./colour_maps";

const decode = (encoded: number) => (encoded <= 0.04045 ? encoded / 12.92 : ((encoded + 0.055) / 1.055) ** 2.4);
function lightness(rgb: number[]): number {
  const y = [0.2126, 0.7152, 0.0722].reduce((sum, weight, k) => sum + weight * decode(rgb[k]! / 255), 0);
  return y > 0.008856 ? 116 * Math.cbrt(y) - 16 : 903.3 * y;
}

describe("colour maps", () => {
  it("rise evenly in lightness from nearly black to nearly white", () => {
    const map = colourMap("magnitude");
    for (let i = 0; i <= 255; ++i) expect(Math.abs(lightness(colourAt(map, i / 255)) - (2 + (96 * i) / 255))).toBeLessThan(1);
  });
  it("are of equal lightness on both sides of no error, blue below and red above", () => {
    const map = colourMap("signed");
    for (let i = 1; i <= 16; ++i) {
      const below = colourAt(map, 0.5 - i / 32);
      const above = colourAt(map, 0.5 + i / 32);
      expect(Math.abs(lightness(below) - lightness(above))).toBeLessThan(1);
      expect(below[2]).toBeGreaterThan(below[0]);
      expect(above[0]).toBeGreaterThan(above[2]);
    }
    expect(Math.max(...colourAt(map, 0.5))).toBeLessThan(10);
  });
  it("mix the heat map's four colours as the daemon does", () => {
    const map = colourMap("heat");
    expect([0, 1 / 3, 2 / 3, 1, 2, 0.5].map((t) => colourAt(map, t))).toEqual([
      [0, 0, 255], [0, 255, 0], [255, 0, 0], [255, 255, 255], [255, 255, 255], [128, 128, 0],
    ]);
  });
  it("encode sRGB as IEC 61966-2-1 has it", () => {
    expect(srgbEncode(0.18)).toBeCloseTo(0.4613561, 6);
    expect(srgbEncode(0.002)).toBeCloseTo(0.02584, 8);
    expect(srgbEncode(1)).toBeCloseTo(1, 12);
  });
});
