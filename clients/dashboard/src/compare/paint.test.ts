import { describe, expect, it } from "vitest";

import { layers } from "../api/vocabulary";
import { someLayers } from "../api/vocabulary.test_data";
import { kStart } from "./look";
import { filmic, kFilmicWhite, paintOf, placeOf, rangeOf, relativeError, roundScale, scaleTitle, signedError, ticksOf, toned, type Ground } from "./paint";

layers.value = someLayers;

const light: Ground = { layer: "beauty", channels: 3, referenceMean: 0.3, low: 0, high: 9 };
const depth: Ground = { layer: "depth", channels: 1, referenceMean: 3, low: 2, high: 5 };

describe("tone curves", () => {
  it("are those of previews, and reach white", () => {
    expect(filmic(0.18)).toBeCloseTo((0.108 * (2.51 * 0.108 + 0.03)) / (0.108 * (2.43 * 0.108 + 0.59) + 0.14), 12);
    expect(filmic(kFilmicWhite)).toBeCloseTo(1, 9);
    expect(filmic(1e30)).toBe(1);
    expect([toned(1, "srgb"), toned(7, "srgb"), toned(-1, "srgb"), toned(NaN, "filmic"), toned(0.25, "linear")]).toEqual([expect.closeTo(1, 12), expect.closeTo(1, 12), 0, 0, 0.25]);
  });
});

describe("errors of a pixel", () => {
  it("are the daemon's: root of the mean of (x - r)^2 / (r^2 + 0.01 m^2)", () => {
    expect(relativeError([1, 2, 3], [1, 1, 1], "rgb", 0)).toBeCloseTo(Math.sqrt(5 / 3), 12);
    expect(relativeError([1, 0, 0], [0, 0, 0], "r", 0.25)).toBe(2);
    expect(relativeError([NaN, 0, 0], [0, 0, 0], "rgb", 1)).toBeNaN();
    expect(relativeError([NaN, 3, 0], [0, 1, 0], "g", 0)).toBe(2);
    expect(relativeError([5], [4], "r", 0)).toBe(0.25);
  });
  it("are signed, of luminance unless a channel is chosen", () => {
    expect(signedError([1, 1, 1], [0, 0, 0], "rgb")).toBeCloseTo(1, 12);
    expect(signedError([0, 0, 1], [0, 1, 3], "b")).toBe(-2);
  });
});

describe("scales", () => {
  it("are round numbers, and the same for all images", () => {
    expect([0.3, 0.07, 1400, 0, 3.5].map(roundScale)).toEqual([0.2, 0.05, 1000, 1, 5]);
    expect(paintOf({ ...kStart, exposure: 4 }, light, "signed")).toMatchObject({ low: -0.2, high: 0.2, channel: "luminance" });
    expect(paintOf({ ...kStart, span: 3 }, light, "signed")).toMatchObject({ low: -3, high: 3 });
    expect(paintOf(kStart, light, "flip_hdr")).toMatchObject({ low: 0, high: 1, colours: "map", quantity: "pixel" });
  });
  it("of values that are no light begin at 0 where that costs little", () => {
    expect(rangeOf(kStart, depth)).toEqual([2, 5]);
    expect(rangeOf(kStart, { ...depth, low: 0.5 })).toEqual([0, 5]);
    expect(rangeOf(kStart, { ...depth, low: null, high: null })).toEqual([0, 1]);
    expect(rangeOf({ ...kStart, range: [1, 3] }, depth)).toEqual([1, 3]);
    expect(paintOf(kStart, { ...light, layer: "normal" }, "none")).toMatchObject({ colours: "straight", low: -1, high: 1 });
    expect(paintOf({ ...kStart, channel: "g" }, { ...light, layer: "normal" }, "none")).toMatchObject({ colours: "map", channel: "g" });
  });
  it("say their numbers", () => {
    const relative = paintOf(kStart, light, "relative");
    expect(ticksOf(relative).map((tick) => tick.text)).toEqual(["0.001", "0.01", "0.1", "1", "10"]);
    expect(placeOf(relative, 0.1)).toBeCloseTo(0.5, 12);
    expect(placeOf(relative, 1e-9)).toBe(0);
    expect(ticksOf(paintOf(kStart, light, "signed")).map((tick) => tick.text)).toEqual(["−0.2", "−0.1", "0", "+0.1", "+0.2"]);
    expect(ticksOf(paintOf({ ...kStart, exposure: 1 }, light, "none")).at(-1)).toEqual({ place: 1, text: "0.5" });
    expect(scaleTitle(paintOf(kStart, light, "signed"), "signed", "beauty", 3)).toBe("Image − reference, luminance");
    const normals = paintOf({ ...kStart, error: "signed" }, { ...light, layer: "normal" }, "signed");
    expect(scaleTitle(normals, "signed", "normal", 3)).toBe("Image − reference, x"); // directions have no luminance
    expect(scaleTitle(relative, "relative", "beauty", 3)).toBe("Relative error");
  });
});
