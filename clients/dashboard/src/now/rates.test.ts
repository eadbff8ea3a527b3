import { describe, expect, it } from "vitest";

import type { DaemonStatus } from "../api/types";
import { rates, type Sample, sampleOf, samplesBefore, withSample } from "./rates";

const sample = (at: number, passes: number): Sample => ({ at, passes, rays: 0, photons: 0, jobs: 0, memory: 0 });

describe("rates from totals", () => {
  it("are over a window that ends with each sample", () => {
    const samples = [sample(10, 0), sample(11, 4), sample(12, 4), sample(13, 10)];
    expect(rates(samples, "passes", 1)).toEqual([null, 4, 0, 6]);
    expect(rates(samples, "passes", 2)).toEqual([null, 4, 2, 3]);
    expect(rates(samples, "passes", 60)).toEqual([null, 4, 2, 10 / 3]);
  });
  it("hold across a time when the page was not looked at", () => {
    expect(rates([sample(10, 0), sample(11, 4), sample(111, 104)], "passes", 5)).toEqual([null, 4, 1]);
  });
  it("are never negative", () => {
    expect(rates([sample(10, 8), sample(11, 4)], "passes", 5)).toEqual([null, 0]);
  });
});

describe("what there was before", () => {
  const now = Date.parse("2026-03-01T12:00:00Z");
  const ago = (seconds: number) => new Date(now - 1000 * seconds).toISOString();
  const before = samplesBefore({ ...sample(1000, 500), rays: 7, jobs: 2, memory: 9 }, [
    { started: ago(100), finished: ago(50), passes_done: 100 },
    { started: ago(20), finished: null, passes_done: 40 },
    { started: null, finished: null, passes_done: 0 },
  ], now);
  it("is told by jobs that have ended or run", () => {
    const at = (seconds: number) => before.find((one) => one.at === 1000 - seconds)!;
    expect([before.length, before[0]!.at]).toEqual([60, 700]);
    expect([at(300), at(75), at(50), at(20), at(5)].map(({ passes }) => passes)).toEqual([360, 410, 460, 460, 490]);
    expect([at(55), at(50)].map(({ jobs }) => jobs)).toEqual([1, 2]);
  });
  it("is nothing before the daemon began, and not known of rays", () => {
    expect(samplesBefore(sample(12, 0), [], now).map(({ at }) => at)).toEqual([2, 7]);
    const all = [...before.slice(-2), { ...sample(1000, 500), rays: 7 }, { ...sample(1002, 504), rays: 11 }];
    expect(rates(all, "rays", 60)).toEqual([null, null, null, 2]);
    expect(rates(all, "passes", 5)).toEqual([null, 2, 2, 2]);
  });
});

describe("samples", () => {
  it("go after five minutes, and with the daemon they are of", () => {
    let samples: Sample[] = [];
    for (let second = 0; second <= 400; ++second) samples = withSample(samples, sample(second, second));
    expect([samples[0]!.at, samples.length]).toEqual([100, 301]);
    expect(withSample(samples, sample(400, 9))).toBe(samples);
    expect(withSample(samples, sample(2, 1))).toEqual([sample(2, 1)]);
  });
  it("add up what is of several kinds", () => {
    const status = {
      uptime_seconds: 5,
      resident_bytes: 100,
      workers: [{ resident_bytes: 10 }, { resident_bytes: null }],
      totals: { jobs: { succeeded: 2, failed: 1, cancelled: 0 }, passes: 7, rays: { camera: 3, shadow: 4 }, photons: 9 },
    } as unknown as DaemonStatus;
    expect(sampleOf(status)).toEqual({ at: 5, passes: 7, rays: 7, photons: 9, jobs: 3, memory: 110 });
  });
});
