import { describe, expect, it } from "vitest";

import { JobList, kPageRows, withChange } from "./job_list";
import type { JobSummary } from "../api/types";

const job = (number: number, state = "succeeded") => ({ id: `J${number}`, state, failure: null, progress: 1, priority: 0 }) as unknown as JobSummary;

/** A daemon with so many jobs, newest first, that notes what it was asked for. */
function daemon(count: number) {
  const jobs = Array.from({ length: count }, (_, index) => job(count - index));
  const requests: [number, number][] = [];
  return {
    jobs,
    requests,
    down: false,
    async fetchPage(offset: number, limit: number, signal: AbortSignal) {
      requests.push([offset, limit]);
      await Promise.resolve();
      if (signal.aborted) throw new DOMException("", "AbortError");
      if (this.down) throw new Error("down");
      return { items: jobs.slice(offset, offset + limit), next_cursor: null, total: jobs.length };
    },
  };
}
const settle = () => new Promise((done) => setTimeout(done, 5));

function listOf(source: ReturnType<typeof daemon>) {
  return new JobList((offset, limit, signal) => source.fetchPage(offset, limit, signal));
}

describe("a list of many jobs", () => {
  it("asks for the pages looked at and no others", async () => {
    const source = daemon(100_000);
    const list = listOf(source);
    list.look(0, 40);
    await settle();
    expect(list.total).toBe(100_000);
    expect(list.row(40)!.id).toBe("J99960");
    list.look(50_090, 50_120);
    await settle();
    expect(source.requests).toEqual([[0, 100], [50_000, 100], [50_100, 100]]);
    expect(list.row(50_100)!.id).toBe("J49900");
    expect(list.row(50_200)).toBeUndefined();
    list.look(50_080, 50_110);
    await settle();
    expect(source.requests).toHaveLength(3);
  });

  it("waits for no page that was scrolled past", async () => {
    const source = daemon(100_000);
    const list = listOf(source);
    list.look(0, 40);
    await settle();
    for (let first = 0; first < 90_000; first += 500) list.look(first, first + 40);
    await settle();
    expect(source.requests.length).toBeLessThan(6);
    expect(list.row(89_540)).toBeDefined();
  });

  it("keeps what is read in its place when jobs come", async () => {
    const source = daemon(1000);
    const list = listOf(source);
    list.look(0, 40);
    await settle();
    list.look(300, 340);
    await settle();
    const read = list.row(310)!.id;
    for (let i = 0; i < 7; ++i) source.jobs.unshift(job(1001 + i, "queued"));
    await list.refresh();
    expect(list.shifted).toBe(7);
    expect(list.row(317)!.id).toBe(read);
    expect(list.total).toBe(1007);
    // And when more came than a page holds.
    for (let i = 0; i < 500; ++i) source.jobs.unshift(job(2001 + i, "queued"));
    await list.refresh();
    expect(list.shifted).toBe(507);
    expect(list.row(817)!.id).toBe(read);
  });

  it("believes an event rather than an answer that was asked for before it", async () => {
    const source = daemon(300);
    const list = listOf(source);
    // The first page, asked for; the daemon's answer is of before the events.
    list.look(0, 40);
    list.patch({ id: "J299", state: "cancelled" });
    await settle();
    expect(list.row(1)!.state).toBe("cancelled");
    const refreshed = list.refresh();
    list.patch({ id: "J298", state: "running" });
    list.patch({ id: "J298", state: "failed" });
    await refreshed;
    expect(list.row(2)!.state).toBe("failed");
    // What is asked for afterwards is newer than they are.
    source.jobs[2] = job(298, "queued");
    await list.refresh();
    expect([1, 2].map((place) => list.row(place)!.state)).toEqual(["succeeded", "queued"]);
  });

  it("moves up when jobs above go", async () => {
    const source = daemon(1000);
    const list = listOf(source);
    list.look(300, 340);
    await settle();
    const read = list.row(310)!.id;
    source.jobs.splice(5, 20);
    await list.refresh();
    expect(list.row(290)!.id).toBe(read);
    expect(list.shifted).toBe(-20);
  });

  it("sees by the total that places have changed", async () => {
    const source = daemon(1000);
    const list = listOf(source);
    list.look(0, 40);
    await settle();
    source.jobs.unshift(job(1001));
    list.look(400, 440);
    await settle();
    expect(list.total).toBe(1001);
    expect(list.row(400)!.id).toBe(source.jobs[400]!.id);
  });

  it("changes rows in place", async () => {
    const list = listOf(daemon(10));
    list.look(0, 40);
    await settle();
    const before = list.version.value;
    expect(list.patch({ id: "J7", state: "running", progress: 0.5 })).toBe(true);
    expect(list.row(3)).toMatchObject({ id: "J7", state: "running", progress: 0.5 });
    expect(list.version.value).toBe(before + 1);
    expect(list.patch({ id: "J700", state: "running" })).toBe(false);
  });

  it("reads a range that is not held, in order", async () => {
    const source = daemon(3000);
    const list = listOf(source);
    list.look(0, 40);
    await settle();
    const rows = await list.range(50, 2500);
    expect(rows.map((row) => row.id)).toEqual(source.jobs.slice(50, 2501).map((row) => row.id));
    expect(source.requests.slice(1)).toEqual([[100, 1000], [1100, 1000], [2100, 401]]);
  });

  it("says that it failed, and goes on when asked", async () => {
    const source = daemon(10);
    const list = listOf(source);
    source.down = true;
    list.look(0, 40);
    await settle();
    expect(list.failure?.message).toBe("down");
    source.down = false;
    await list.refresh();
    expect(list.failure).toBeNull();
    expect(list.total).toBe(10);
  });

  it("forgets what is far", async () => {
    const source = daemon(50_000);
    const list = listOf(source);
    for (let first = 0; first < 7000; first += kPageRows) {
      list.look(first, first + 40);
      await settle();
    }
    expect([...list.loaded()].length).toBeLessThan(6100);
    expect(list.row(6_900)).toBeDefined();
    expect(list.row(0)).toBeUndefined();
    list.look(0, 40);
    await settle();
    expect(list.row(0)!.id).toBe("J50000");
  });
});

describe("an event", () => {
  it("changes what it names", () => {
    expect(withChange(job(1), { id: "J1", priority: 7 })).toMatchObject({ priority: 7, state: "succeeded" });
    const failure = { type: "about:blank", title: "Failed", status: 500, detail: "crashed" };
    expect(withChange(job(1), { id: "J1", failure }).failure).toBe("crashed");
  });
});
