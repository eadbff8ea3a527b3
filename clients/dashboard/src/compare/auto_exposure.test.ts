import { describe, expect, it } from "vitest";

import { autoExposureStops } from "./auto_exposure";
import { pixelImage } from "./pixels";

const image = (...values: number[]) => pixelImage(values.length / 3, 1, 3, new Float32Array(values));
const grey = (...values: number[]) => image(...values.flatMap((value) => [value, value, value]));

describe("exposure by the image", () => {
  it("brings the log-average luminance to middle grey", () => {
    expect(autoExposureStops(grey(0.18))).toBeCloseTo(0, 9);
    expect(autoExposureStops(grey(0.18 / 4, 0.18 / 16))).toBeCloseTo(3, 9); // not by the mean, which would say 2.7
    expect(autoExposureStops(image(0, 0.18 / 0.7152, 0))).toBeCloseTo(0, 2);
  });
  it("looks at what is lit and finite alone", () => {
    expect(autoExposureStops(grey(0.36, 0, -1, NaN, Infinity, 1e-9))).toBeCloseTo(-1, 9);
    expect(autoExposureStops(grey(0, NaN))).toBeNull();
  });
});
