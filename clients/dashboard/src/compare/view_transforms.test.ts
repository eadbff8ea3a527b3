import { describe, expect, it } from "vitest";

import { srgbEncode } from "./colour_maps";
import { kCurves } from "./look";
import { displayed, toned, whiteLight } from "./paint";
import { acesFitted, agx, pbrNeutral, type Triple } from "./view_transforms";

const expectNear = (found: Triple, wanted: Triple, digits: number) => found.forEach((value, k) => expect(value).toBeCloseTo(wanted[k]!, digits));

describe("Khronos PBR Neutral", () => {
  it("keeps base colours, less the reflection of a dielectric", () => {
    // The specification's promise: for a base colour within 0.8 under grey light of 1, plus a reflection of 0.04, the
    // display shows the base colour.
    for (const colour of [[0.5, 0.5, 0.5], [0.7, 0.2, 0.1], [0.76, 0.04, 0.3]] as Triple[]) expectNear(pbrNeutral(colour.map((x) => x + 0.04) as Triple), colour, 12);
    // Below twice that reflection its share falls as 6.25 x^2: x - (x - 6.25 x^2).
    expectNear(pbrNeutral([0.04, 0.04, 0.04]), [0.01, 0.01, 0.01], 12);
    expectNear(pbrNeutral([0.3, 0.04, 0.2]), [0.27, 0.01, 0.17], 12);
  });
  it("rolls highlights off and takes their colour, by the reference GLSL's arithmetic", () => {
    // Grey 1: peak 0.96, d = 0.24, 1 - d^2 / (0.96 + d - 0.76) = 1 - 0.0576 / 0.44.
    expectNear(pbrNeutral([1, 1, 1]), [0.869090909, 0.869090909, 0.869090909], 8);
    // (10, 0.04, 0.04): offset 0.03, peak 9.97, new peak 1 - 0.0576 / 9.45 = 0.99390476,
    // g = 1 - 1 / (0.15 (9.97 - 0.99390476) + 1) = 0.57381780; 0.01 * 0.99390476 / 9.97 = 0.00099690.
    expectNear(pbrNeutral([10, 0.04, 0.04]), [0.99390476, 0.5707451, 0.5707451], 6);
  });
  it("is continuous where compression begins", () => {
    const at = (x: number) => pbrNeutral([x, x / 2, x / 3])[0];
    expect(at(0.8 + 1e-7) - at(0.8 - 1e-7)).toBeLessThan(1e-5);
  });
});

describe("ACES fitted", () => {
  it("is Hill's curve between his matrices, whose rows keep grey", () => {
    // (0.18 (0.18 + 0.0245786) - 0.000090537) / (0.18 (0.983729 0.18 + 0.432951) + 0.238081) = 0.10559
    expectNear(acesFitted([0.18, 0.18, 0.18]), [0.10559, 0.10559, 0.10559], 4);
    expectNear(acesFitted([1, 1, 1]), [0.61912, 0.61912, 0.61912], 4);
    // Red alone is let into the other channels: 0.0760 and 0.0284 of it, before the curve.
    const [red, green, blue] = acesFitted([4, 0, 0]);
    expect(red).toBeGreaterThan(0.9);
    expect(green).toBeGreaterThan(0);
    expect(green).toBeLessThan(0.2);
    expect(blue).toBeLessThan(green);
  });
});

/** The curve that the polynomial stands for [Sobotka 2022]: two power sigmoids of slope 2 that meet at middle grey, 10 of 16.5 stops up. */
function agxContrast(place: number): number {
  const from = place - 20 / 33;
  const power = from < 0 ? 3 : 3.25;
  const end = from < 0 ? 20 / 33 : 13 / 33; // where the curve must have come to 0.5 from the middle
  const scale = (4 * end) ** power - 1; // so that 2 end / (1 + scale)^(1 / power) is 0.5
  return 0.5 + (2 * from) / (1 + scale * (Math.abs(from) / end) ** power) ** (1 / power);
}

describe("AgX", () => {
  it("is its own curve for grey, as near as the polynomial comes", () => {
    let squares = 0;
    const count = 400;
    for (let i = 0; i <= count; ++i) {
      const grey = 2 ** (-12.47393 + (16.5 * i) / count);
      const error = agx([grey, grey, grey])[1] - agxContrast(i / count);
      expect(Math.abs(error)).toBeLessThan(0.008);
      squares += error * error;
    }
    expect(squares / count).toBeLessThan(8e-6); // [Wrensch 2023] says 3.67e-6 of the table's own steps
  });
  it("keeps grey grey and takes colour from what is bright", () => {
    for (const x of [0.01, 0.18, 1, 8]) {
      const [r, g, b] = agx([x, x, x]);
      expect(Math.max(r, g, b) - Math.min(r, g, b)).toBeLessThan(1e-3);
    }
    const spread = (x: number) => {
      const colour = agx([x, 0, 0]).map((v) => Math.min(1, Math.max(0, v)));
      return Math.max(...colour) - Math.min(...colour);
    };
    expect(spread(200)).toBeLessThan(spread(1));
  });
});

describe("every curve", () => {
  it("rises from black to white, and the scale ends where grey light is shown white", () => {
    for (const curve of kCurves) {
      let before = -1;
      for (let stops = -12; stops <= 8; stops += 0.125) {
        const now = toned(2 ** stops, curve);
        expect(now).toBeGreaterThanOrEqual(before - 1e-9);
        expect(now).toBeLessThanOrEqual(1);
        before = now;
      }
      expect(toned(0, curve)).toBeLessThan(1 / 255);
      expect(Math.round(255 * toned(whiteLight(curve), curve))).toBe(255);
      expect(Math.round(255 * toned(0.5 * whiteLight(curve), curve))).toBeLessThan(255);
    }
  });
  it("is of each channel alone for those that clip", () => {
    expectNear(displayed([0.18, 2, -1], "srgb"), [srgbEncode(0.18), 1, 0], 12);
    expectNear(displayed([0.18, 2, -1], "linear"), [0.18, 1, 0], 12);
  });
});
