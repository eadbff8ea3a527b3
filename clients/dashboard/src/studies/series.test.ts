import { describe, expect, it } from "vitest";

import type { ComparisonReport, ComparisonRow, MeanPoint } from "../api/types";
import { metrics } from "../api/vocabulary";
import { someMetrics } from "../api/vocabulary.test_data";
import {
  bestByTime, byteTicks, defaultBand, errorAt, fittedSlope, frontWithMemory, idealSlope, isNoiseKnown, logTicks, readingAt, referenceJobs, rowName, seriesOf, type Series,
} from "./series";

const point = (seconds: number, error: number): MeanPoint => ({ seconds, error, low: null, high: null, min: error, max: error });
const power = (scale: number, exponent: number, times = [0.1, 0.2, 0.4, 0.8, 1.6, 3.2]) => times.map((time) => point(time, scale * time ** exponent));
const series = (row: number, points: MeanPoint[]): Series => ({ row, name: `row ${row}`, points, band: null, slope: null, leftOut: 0 });

describe("slopes", () => {
  it("are the exponent of a power law", () => {
    expect(fittedSlope(power(0.3, -1))).toBeCloseTo(-1, 10);
    expect(fittedSlope(power(7, -0.5))).toBeCloseTo(-0.5, 10);
  });
  it("leave out what comes before the last decade", () => {
    const start = [point(0.001, 100), point(0.01, 100)];
    expect(fittedSlope([...start, ...power(0.3, -1, [1, 2, 4, 10])])).toBeCloseTo(-1, 10);
  });
  it("are not told of two points or of one time", () => {
    expect(fittedSlope(power(1, -1, [1, 2]))).toBeNull();
    expect(fittedSlope([point(1, 1), point(1, 2), point(1, 3)])).toBeNull();
    expect(fittedSlope([])).toBeNull();
  });
  it("have an ideal where the daemon tells of one", () => {
    expect(idealSlope("rmse")).toBeNull();
    metrics.value = someMetrics;
    expect(["relative_mse", "indirect:relative_mse", "rmse", "flip_hdr", "smape"].map(idealSlope)).toEqual([-1, -1, -0.5, null, null]);
  });
});

describe("a report's curves", () => {
  const crossed = (seconds: number, error: number, interval: [number, number] | null): MeanPoint => ({ seconds, error, low: error - 1, high: error + 1, min: error / 2, max: error * 2, interval });
  const report = (seeds: number, points: MeanPoint[]) =>
    ({ table: [{ label: "a", parameters: {}, seeds, error: {}, mean_curve: { relative_mse: points } }] }) as unknown as ComparisonReport;
  const three = [crossed(1, 0.5, [0.4, 0.6]), crossed(2, -0.1, [-0.3, 0.1]), crossed(4, -0.2, null)];

  it("have upper bounds where an error is not told apart from 0, and count what cannot be drawn", () => {
    const [one] = seriesOf(report(1, three), "relative_mse", "noise");
    expect(one!.points.map((at) => [at.seconds, at.error, at.isBound])).toEqual([[1, 0.5, false], [2, 0.1, true]]);
    expect(one!.band).toEqual([{ low: 0.4, high: 0.6 }, { low: -0.3, high: 0.1 }]);
    expect(one!.leftOut).toBe(1);
  });
  it("have a band over the seeds where there are several, also one that reaches below 0", () => {
    expect(seriesOf(report(3, three), "relative_mse", "interval")[0]!.band).toEqual([{ low: -0.5, high: 1.5 }, { low: -1.1, high: 0.9 }]);
    expect(seriesOf(report(3, three), "relative_mse", "range")[0]!.band).toEqual([{ low: 0.25, high: 1 }, null]);
    expect(seriesOf(report(1, three), "relative_mse", "interval")[0]!.band).toBeNull();
    expect(seriesOf(report(1, [point(1, 0.5)]), "relative_mse", "noise")[0]!.band).toBeNull();
  });
  it("say whether the reference's noise is known apart, and with one seed show what it leaves open", () => {
    expect(isNoiseKnown(report(1, three), "relative_mse")).toBe(true);
    expect(isNoiseKnown(report(1, [point(1, 0.5)]), "relative_mse")).toBe(false);
    expect(isNoiseKnown(report(1, three), "smape")).toBe(false);
    expect([defaultBand(1, true), defaultBand(1, false), defaultBand(2, true), defaultBand(4, true)]).toEqual(["noise", "none", "range", "interval"]);
  });
  it("are against two films, one or an image", () => {
    const reference = { job: "J1", image: null, state: null, error: null, warnings: [] };
    expect(referenceJobs({ reference: { ...reference, jobs: ["J1", "J2"] } })).toEqual(["J1", "J2"]);
    expect(referenceJobs({ reference })).toEqual(["J1"]);
    expect(referenceJobs({ reference: { ...reference, job: null, jobs: null } })).toEqual([]);
    expect(referenceJobs({ reference: null })).toEqual([]);
  });
});

describe("curves", () => {
  it("are no more than bounded beside an upper bound, and have no slope by one", () => {
    const points = [point(1, 1), { ...point(10, 0.1), isBound: true }, point(100, 0.01)];
    expect(readingAt(points, 3)).toMatchObject({ isBound: true });
    expect(readingAt(points, 100)).toEqual({ error: 0.01, isBound: false });
    expect(readingAt(points, 200)).toBeNull();
    expect(fittedSlope([point(1, 1), { ...point(2, 5), isBound: true }, point(4, 0.25), point(8, 0.125)])).toBeCloseTo(-1, 10);
    expect(fittedSlope([point(1, 1), { ...point(2, 5), isBound: true }, point(4, 0.25)])).toBeNull();
  });
  it("are straight in log-log between their points, and nothing outside", () => {
    const points = [point(1, 1), point(100, 0.01)];
    expect(errorAt(points, 10)).toBeCloseTo(0.1, 12);
    expect(errorAt(points, 100)).toBe(0.01);
    expect(errorAt(points, 0.5)).toBeNull();
    expect(errorAt(points, 101)).toBeNull();
  });
  it("take turns at being lowest, from where they cross", () => {
    const quick = series(0, [point(0.1, 1), point(10, 0.1)]);
    const steep = series(1, [point(0.1, 10), point(10, 0.001)]);
    const found = bestByTime([quick, steep]);
    expect(found.map((stretch) => stretch.row)).toEqual([0, 1]);
    // 10^(-1/2 x - 1/2) and 10^(-2 x - 1) meet at x = -1/3.
    expect(found[0]!.to).toBeCloseTo(10 ** (-1 / 3), 6);
    expect(found[1]!.to).toBe(10);
  });
  it("keep their last value once they have ended", () => {
    const short = series(0, [point(0.1, 1), point(1, 0.001)]);
    const long = series(1, [point(0.1, 2), point(10, 0.1)]);
    expect(bestByTime([short, long])).toEqual([{ row: 0, from: 0.1, to: 10 }]);
  });
  it("are on the front with memory when nobody as small is as good", () => {
    const rows = [100, 10, 200].map((peak_bytes) => ({ peak_bytes }) as ComparisonRow);
    const all = [series(0, power(1, -1)), series(1, power(3, -1)), series(2, power(2, -1))];
    expect(frontWithMemory(all, rows)).toEqual([0, 1]);
    rows[1]!.peak_bytes = null;
    expect(frontWithMemory(all, rows)).toEqual([0]);
  });
});

describe("words and ticks", () => {
  it("names a row by its label and what was swept", () => {
    expect(rowName({ label: "a", parameters: { photons: 5000, filter: "cone" } })).toBe("a, photons 5000, filter cone");
  });
  it("has powers of ten, and 1-2-5 on a short axis", () => {
    expect(logTicks(0.011, 0.9)).toEqual([0.02, 0.05, 0.1, 0.2, 0.5]);
    expect(logTicks(0.001, 10)).toEqual([0.001, 0.01, 0.1, 1, 10]);
    expect(byteTicks(7 * 2 ** 20, 40 * 2 ** 20)).toEqual([8 * 2 ** 20, 16 * 2 ** 20, 32 * 2 ** 20]);
    expect(byteTicks(1, 2 ** 40).length).toBeLessThan(10);
    expect(byteTicks(5, 7)).toEqual([]);
  });
});
