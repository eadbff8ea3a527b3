import { describe, expect, it } from "vitest";

import { cropAbout, cropBetween, cropsOfText, cropsText, cropWithin } from "./crops";

const image = { width: 100, height: 60 };

describe("crops", () => {
  it("hold the pixels of both corners, in whichever order they were drawn", () => {
    expect(cropBetween({ x: 10.7, y: 20.2 }, { x: 5.1, y: 25.9 }, image)).toEqual({ x: 5, y: 20, width: 6, height: 6 });
    expect(cropBetween({ x: -20, y: 50 }, { x: 500, y: 500 }, image)).toEqual({ x: 0, y: 50, width: 100, height: 10 });
    expect(cropBetween({ x: -20, y: 0 }, { x: -3, y: 10 }, image)).toBeNull();
  });
  it("are put about a place without leaving the image", () => {
    expect(cropAbout({ x: 50.5, y: 30.5 }, image)).toEqual({ x: 26, y: 6, width: 48, height: 48 });
    expect(cropAbout({ x: 0, y: 59 }, image)).toEqual({ x: 0, y: 12, width: 48, height: 48 });
    expect(cropAbout({ x: 3, y: 3 }, { width: 8, height: 8 })).toEqual({ x: 0, y: 0, width: 8, height: 8 });
    expect(cropWithin({ x: 90, y: -5, width: 2000, height: NaN }, image)).toEqual({ x: 0, y: 0, width: 100, height: 1 });
  });
  it("come back from a link", () => {
    const crops = [{ x: 0, y: 1, width: 2, height: 3 }, { x: 4, y: 5, width: 6, height: 7 }];
    expect(cropsOfText(cropsText(crops))).toEqual({ crops, faults: [] });
    expect(cropsOfText("1,2,0,4;1,2,3;1.5,2,3,4")).toMatchObject({ crops: [], faults: [{}, {}, {}].map(() => expect.stringContaining("whole pixels")) });
  });
});
