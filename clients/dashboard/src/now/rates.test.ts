import { describe, expect, it } from "vitest";

import type { DaemonStatus } from "../api/types";
import { rates, type Sample, sampleOf, withSample } from "./rates";

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
