import { describe, expect, it } from "vitest";

import { besideOf, kStart, lookOf, queryOf, sourceOfText, withImages, withoutImage, type Look } from "./look";

const asAddress = (look: Look): Record<string, string> =>
  Object.fromEntries(Object.entries(queryOf(look)).filter((member): member is [string, string] => member[1] !== null));

describe("the address of a view", () => {
  it("says nothing of what is as at the start", () => {
    expect(asAddress(kStart)).toEqual({});
    expect(lookOf({})).toEqual({ look: kStart, faults: [] });
  });
  it("brings back every part of it", () => {
    const look: Look = {
      images: ["job:J3", "image:abcdef0123", "job:J9"],
      reference: "job:J9",
      layer: "indirect",
      mode: "wipe",
      shown: 1,
      beside: 0,
      zoom: 3.5,
      centre: { x: 100.25, y: 31 },
      exposure: -1.5,
      curve: "filmic",
      colours: "magma",
      channel: "luminance",
      error: "signed",
      span: 0.05,
      range: [0, 12],
      wipe: 0.3125,
      wipeAcross: true,
      crops: [{ x: 1, y: 2, width: 3, height: 4 }, { x: 10, y: 20, width: 30, height: 40 }],
      cropZoom: 5,
      pixel: { x: 7, y: 8 },
      precision: "float",
    };
    expect(Object.keys(asAddress(look)).length).toBe(Object.keys(queryOf(look)).length);
    expect(lookOf(asAddress(look))).toEqual({ look, faults: [] });
  });
  it("names each fault and goes on without it", () => {
    const { look, faults } = lookOf({
      images: "job:J1,nonsense!,job:J2", show: "5", mode: "spin", zoom: "1e9", at: "3", reference: "job:J7", range: "3,1", crops: "1,2,3;1,2,3,4", exposure: "much",
    });
    expect(look).toEqual({ ...kStart, images: ["job:J1", "job:J2"], crops: [{ x: 1, y: 2, width: 3, height: 4 }] });
    expect(faults).toHaveLength(9);
    expect(faults.join("\n")).toContain("show=5: there are images 1 to 2");
    expect(faults.join("\n")).toContain("zoom=1e9: must be a number from 0.015625 to 128");
  });
  it("takes nine images at most, each once", () => {
    const images = Array.from({ length: 11 }, (_, i) => `job:J${i}`);
    expect(lookOf({ images: [...images, "J0"].join(",") })).toEqual({
      look: { ...kStart, images: images.slice(0, 9) },
      faults: ["images: 11 are named; the first 9 are shown"],
    });
    expect(withImages({ ...kStart, images: images.slice(0, 8) }, ["job:J2", "job:J9", "job:J10"]).images).toHaveLength(9);
  });
  it("understands what people type for an image", () => {
    expect(["J17", " 17 ", "j4", "job:J1", "image:0af3", "deadbeef0123", "x", "job:"].map(sourceOfText)).toEqual([
      "job:J17", "job:J17", "job:J4", "job:J1", "image:0af3", "image:deadbeef0123", null, null,
    ]);
  });
});

describe("which images are meant", () => {
  const look: Look = { ...kStart, images: ["job:A", "job:B", "job:C"], reference: "job:B", shown: 2, beside: 1 };
  it("stays the same ones when another is taken away", () => {
    expect(withoutImage(look, 0)).toMatchObject({ images: ["job:B", "job:C"], reference: "job:B", shown: 1, beside: 0 });
    expect(withoutImage(look, 1)).toMatchObject({ reference: null, shown: 1, beside: null });
    expect(withoutImage(look, 2)).toMatchObject({ shown: 1, beside: 1 });
  });
  it("puts the reference beside what is shown, and the next beside the reference", () => {
    expect(besideOf({ ...look, beside: null }, 1)).toBe(1);
    expect(besideOf({ ...look, beside: null, shown: 1 }, 1)).toBe(2);
    expect(besideOf({ ...look, beside: 0 }, 1)).toBe(0);
  });
});
