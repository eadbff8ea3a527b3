import { describe, expect, it } from "vitest";

import { lightHistogram, valueHistogram } from "./histogram";
import { pixelImage } from "./pixels";

const grey = (...values: number[]) => pixelImage(values.length, 1, 3, new Float32Array(values.flatMap((value) => [value, value, value])));

describe("histograms", () => {
  it("count light by stops, and what is black, and what is shown white", () => {
    const { shares, low, high, black, above } = lightHistogram(grey(1, 1, 2, 0, -3, 8, NaN, Infinity), 1.5);
    const at = (stops: number) => shares[Math.floor(((stops - low) / (high - low)) * shares.length)]!;
    expect([at(0), at(1), at(3), black, above]).toEqual([2 / 6, 1 / 6, 1 / 6, 2 / 6, 2 / 6].map((share) => expect.closeTo(share, 9)));
    expect(shares.reduce((sum, share) => sum + share, 0) + black).toBeCloseTo(1, 9);
  });
  it("keep what lies beyond their ends in the last bins", () => {
    const { shares } = lightHistogram(grey(1e-9, 1e9), 1);
    expect([shares[0], shares.at(-1)]).toEqual([0.5, 0.5]);
  });
  it("count values evenly over their scale", () => {
    const image = pixelImage(4, 1, 1, new Float32Array([0, 1, 2, 3.99]));
    const { shares } = valueHistogram(image, 0, 4);
    expect([0, 1, 2, 3].map((quarter) => shares.slice((quarter * shares.length) / 4, ((quarter + 1) * shares.length) / 4).reduce((sum, share) => sum + share, 0))).toEqual([0.25, 0.25, 0.25, 0.25]);
  });
  it("are of nothing where nothing is finite", () => {
    expect(lightHistogram(grey(NaN), 1).shares.every((share) => share === 0)).toBe(true);
  });
});
