import { describe, expect, it } from "vitest";

import type { CurvePoint, NoiseInterval } from "../api/types";
import { boundsOf, errorPoints, lineOf } from "./error_points";

const point = (passes: number, value: number | null, interval?: NoiseInterval): CurvePoint => ({
  seconds: passes / 10, passes, photons: null, metrics: { relative_mse: value, smape: passes === 2 ? 0.5 : null }, ...(interval ? { intervals: { relative_mse: interval } } : {}),
});

describe("the points of a curve", () => {
  it("are values with their intervals, and upper bounds", () => {
    const { x, drawn, leftOut } = errorPoints([point(1, 0.5, [0.4, 0.6]), point(2, -0.1, [-0.3, 0.1]), point(4, 0.05)], ["relative_mse"], "passes");
    expect([x, leftOut]).toEqual([[1, 2, 4], 0]);
    expect(drawn[0]!.map((error) => [error!.at, error!.isBound, error!.least])).toEqual([[0.5, false, 0.4], [0.1, true, -0.3], [0.05, false, 0.05]]);
    expect(lineOf(drawn[0]!)).toEqual([0.5, null, 0.05]);
    expect(boundsOf(drawn[0]!)).toEqual([null, 0.1, null]);
  });
  it("are passed over where nothing was measured, and counted where nothing can be drawn", () => {
    const { x, drawn, leftOut } = errorPoints([point(1, 0.5), point(2, -0.1), point(4, 0)], ["relative_mse", "smape"], "seconds");
    expect([x, leftOut]).toEqual([[0.1, 0.2], 2]);
    expect(lineOf(drawn[0]!)).toEqual([0.5, undefined]);
    expect(lineOf(drawn[1]!)).toEqual([undefined, 0.5]);
  });
});
