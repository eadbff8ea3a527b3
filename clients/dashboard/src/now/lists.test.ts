import { describe, expect, it } from "vitest";

import type { JobSummary } from "../api/types";
import { afterChange, type Lists } from "./lists";

const row = (id: string, members: Partial<JobSummary> = {}): JobSummary => ({
  id,
  role: "render",
  comparison: null,
  state: "queued",
  progress: 0,
  passes_done: 0,
  seconds: 0,
  error_now: null,
  created: "2026-01-01T00:00:00Z",
  started: null,
  finished: null,
  scene: "cornell-box",
  method: "path_tracing",
  device: "cpu",
  width: 64,
  height: 64,
  priority: 0,
  labels: {},
  waits_for: null,
  failure: null,
  ...members,
});

const lists: Lists = {
  running: [row("J3", { state: "running", progress: 0.5, seconds: 4 })],
  queue: [row("J4"), row("J5")],
  queued: 7,
  recent: [row("J2", { state: "succeeded" })],
  total: 9,
};
const ids = (rows: JobSummary[]) => rows.map((job) => job.id);

describe("lists kept by events", () => {
  it("shows how far a running job has come, without asking", () => {
    const after = afterChange(lists, { id: "J3", progress: 0.75, passes_done: 12, seconds: 6, error_now: { metric: "rmse", value: 0.1 } });
    expect(after.stale).toBe(false);
    expect(after.lists.running[0]).toMatchObject({ progress: 0.75, passes_done: 12, seconds: 6, scene: "cornell-box" });
    expect(after.lists.queue).toBe(lists.queue);
  });
  it("moves a job that begins out of the queue", () => {
    const after = afterChange(lists, { id: "J4", state: "running" });
    expect(ids(after.lists.queue)).toEqual(["J5"]);
    expect(ids(after.lists.running)).toEqual(["J3", "J4"]);
    expect(after.lists.queued).toBe(6);
    expect(after.stale).toBe(true);
  });
  it("puts what has ended first among the recent, with why it failed", () => {
    const failure = { type: "x", title: "Out of memory", status: 422, detail: "held 3 GiB" };
    const after = afterChange(lists, { id: "J3", state: "failed", failure });
    expect(ids(after.lists.recent)).toEqual(["J3", "J2"]);
    expect(after.lists.recent[0]!.failure).toBe("held 3 GiB");
    expect(ids(after.lists.running)).toEqual([]);
  });
  it("counts a retried job as waiting again", () => {
    const after = afterChange(lists, { id: "J2", state: "queued" });
    expect(after.lists.queued).toBe(8);
    expect(ids(after.lists.recent)).toEqual([]);
    expect(after.stale).toBe(true);
  });
  it("must ask about jobs it does not know, and about an order that has changed", () => {
    expect(afterChange(lists, { id: "J10", state: "queued" }).stale).toBe(true);
    expect(afterChange(lists, { id: "J10", curve: [] })).toEqual({ lists, stale: false });
    const raised = afterChange(lists, { id: "J5", priority: 20, state: "queued" });
    expect(raised.lists.queue[1]!.priority).toBe(20);
    expect(raised.stale).toBe(true);
  });
});

