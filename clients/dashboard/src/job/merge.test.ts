import { describe, expect, it } from "vitest";

import { changesMore, spansOf, withEvent, withPoints } from "./merge";
import type { Job } from "../api/types";

const point = (passes: number) => ({ passes, seconds: passes / 10, photons: null, metrics: {} });
const at = (seconds: number) => new Date(1e12 + seconds * 1000).toISOString();
const job = {
  id: "J1", state: "queued", created: at(0), finished: null, passes_done: 0, attempts: [], curve: null, request: { priority: 0, scene: "x" },
} as unknown as Job;

describe("a job and what is told of it", () => {
  it("takes what an event names and keeps the rest", () => {
    const next = withEvent(job, "state", { id: "J1", state: "running", progress: 0.5, priority: 9 });
    expect(next).toMatchObject({ state: "running", progress: 0.5, request: { priority: 9, scene: "x" } });
    expect(changesMore(job, { id: "J1", state: "running" })).toBe(true);
    expect(changesMore(next, { id: "J1", progress: 0.6 })).toBe(false);
  });
  it("grows its curve, each point once", () => {
    const next = withEvent({ ...job, curve: [point(1), point(2)] }, "curve", { id: "J1", curve: [point(2), point(8), point(4)] });
    expect(next.curve!.map(({ passes }) => passes)).toEqual([1, 2, 4, 8]);
    expect(withPoints(null, [point(1)])).toHaveLength(1);
  });
});

describe("a job's life", () => {
  const attempt = (number: number, start: number, end: number | null, outcome: string, passes: number) => ({
    attempt: number, device: "cpu", started: at(start), finished: end === null ? null : at(end), outcome, reason: outcome === "lost" ? "the worker was killed" : null, passes_done: passes,
  });
  const brief = (of: Job, now = 1e12 + 100_000) => spansOf(of, now).map(({ kind, title, outcome, start, end }) => [kind, title, outcome, (start - 1e12) / 1000, (end - 1e12) / 1000]);
  it("waits until now", () => {
    expect(brief(job)).toEqual([["waiting", "queued", "", 0, 100]]);
  });
  it("is lost and goes on", () => {
    const lost = { ...job, state: "running", attempts: [attempt(1, 2, 5, "lost", 7), attempt(2, 6, null, "running", 7)] } as Job;
    expect(brief(lost)).toEqual([
      ["waiting", "queued", "", 0, 2],
      ["attempt", "attempt 1", "lost", 2, 5],
      ["waiting", "queued again", "", 5, 6],
      ["attempt", "attempt 2, going on", "running", 6, 100],
    ]);
  });
  it("may end before it began", () => {
    expect(brief({ ...job, state: "cancelled", finished: at(3) })).toEqual([["waiting", "queued", "", 0, 3]]);
  });
});
