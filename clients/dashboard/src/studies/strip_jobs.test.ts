import { describe, expect, it } from "vitest";

import type { ComparisonReport, JobSummary } from "../api/types";
import { readStrip, stripFilter, stripJobs, stripRequests, stripText } from "./strip_jobs";

const report = {
  id: "C7",
  request: {
    scene: "cornell-box",
    image: { width: 64, height: 64 },
    reference: { method: { name: "path_tracing" }, stop: { passes: 256 } },
    entries: [{ label: "paths", method: { name: "path_tracing", device: "cpu", parameters: {} } }, { label: "photons", method: { name: "photon_mapping", parameters: { gather: "direct" } }, sweep: { photons: [1000, 4000] } }],
    stop: { seconds: 3, passes: null, target: null },
    metrics: ["relative_mse", "estimated_relative_mse"],
    seeds: [5, 6],
    labels: { project: "x" },
    title: "Which is sooner",
    notes: null,
  },
  reference: { job: "J1" },
  table: [
    { label: "paths", parameters: {}, time_to_error: { relative_mse: [{ error: 0.01, seconds: 2 }] } },
    { label: "photons", parameters: { photons: 1000 }, time_to_error: { relative_mse: [{ error: 0.01, seconds: null }] } },
    { label: "photons", parameters: { photons: 4000 }, time_to_error: { relative_mse: [{ error: 0.01, seconds: 0.5 }] } },
  ],
} as unknown as ComparisonReport;

describe("a strip", () => {
  it("is in the address", () => {
    for (const text of ["error 0.01", "time 2", ""]) expect(stripText(readStrip(text, "relative_mse"))).toBe(text);
    expect(readStrip("time -1", "x")).toEqual({ kind: "end" });
    expect(readStrip("nonsense 3", "x")).toEqual({ kind: "end" });
  });
  it("asks for the same job to a target, of the entries that got there", () => {
    const requests = stripRequests(report, { kind: "error", metric: "relative_mse", error: 0.01 });
    expect(requests[1]).toBeNull();
    expect(requests[0]).toMatchObject({
      scene: "cornell-box", seed: 5, reference: "job:J1", metrics: ["relative_mse"], method: { name: "path_tracing" },
      stop: { target: { metric: "relative_mse", value: 0.01 }, seconds: 8 },
      labels: { project: "x", strip: "C7 relative_mse 0.01", entry: "paths" },
    });
    for (const member of ["entries", "title", "notes"]) expect(requests[0]).not.toHaveProperty(member); // a job has none
    expect(requests[0]).not.toHaveProperty("seeds");
    expect(requests[2]!.method.parameters).toEqual({ gather: "direct", photons: 4000 });
    expect(requests[2]!.stop.seconds).toBe(5);
  });
  it("asks for two films as they were asked for, for one of them would measure otherwise", () => {
    const films = { ...report, reference: { ...report.reference!, jobs: ["J1", "J2"] } };
    expect(stripRequests(films, { kind: "time", seconds: 1 })[0]!.reference).toEqual(report.request.reference);
  });
  it("asks everybody for the same time", () => {
    expect(stripRequests(report, { kind: "time", seconds: 1 }).map((request) => request!.stop)).toEqual([{ seconds: 1 }, { seconds: 1 }, { seconds: 1 }]);
    expect(stripRequests(report, { kind: "end" })).toEqual([null, null, null]);
  });
  it("finds its jobs again by their labels, the newest of each entry", () => {
    expect(stripFilter("C7", { kind: "time", seconds: 1 })).toBe("strip=C7 seconds 1");
    const job = (id: string, entry: string) => ({ id, labels: { entry } }) as unknown as JobSummary;
    const found = stripJobs(report, [job("J9", "paths"), job("J5", "paths"), job("J4", "photons, photons 4000")]);
    expect(found.map((one) => one?.id ?? null)).toEqual(["J9", null, "J4"]);
  });
});
