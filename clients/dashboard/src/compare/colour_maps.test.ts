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
  it("come near the tables of those that others know", () => {
    // matplotlib's entries 0, 128 and 255, and turbo's.
    const tables = {
      viridis: [[68, 1, 84], [33, 145, 140], [253, 231, 37]],
      magma: [[0, 0, 4], [183, 55, 121], [252, 253, 191]],
      inferno: [[0, 0, 4], [188, 55, 84], [252, 255, 164]],
      plasma: [[13, 8, 135], [204, 71, 120], [240, 249, 33]],
      turbo: [[48, 18, 59], [164, 252, 60], [122, 4, 3]],
    } as const;
    for (const [name, colours] of Object.entries(tables))
      colours.forEach((colour, k) => {
        const found = colourAt(colourMap(name as keyof typeof tables), [0, 128 / 255, 1][k]!);
        const most = name === "turbo" ? 33 : 14; // its polynomial leaves its table at the ends
        for (const [channel, value] of colour.entries()) expect(Math.abs(found[channel]! - value), `${name} ${k} ${channel}: ${found}`).toBeLessThan(most);
      });
    expect([0, 0.5, 1].map((t) => colourAt(colourMap("grey"), t))).toEqual([[0, 0, 0], [119, 119, 119], [255, 255, 255]]);
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
