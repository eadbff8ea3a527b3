import { describe, expect, it } from "vitest";

import { clampPriority, doToAll, jobsText, statesFor } from "./bulk";

const ids = Array.from({ length: 50 }, (_, index) => `J${index}`);

describe("one thing done to many jobs", () => {
  it("is done to each once, a few at a time, and keeps what failed", async () => {
    const seen: string[] = [];
    let now = 0;
    let most = 0;
    const told: number[] = [];
    const end = await doToAll(
      ids,
      async (id) => {
        most = Math.max(most, ++now);
        await new Promise((done) => setTimeout(done, 1));
        --now;
        seen.push(id);
        if (id === "J7") throw new Error("J7 is over");
      },
      (progress) => told.push(progress.done),
      new AbortController().signal,
    );
    expect(seen.sort()).toEqual([...ids].sort());
    expect(most).toBe(4);
    expect(told).toEqual(ids.map((_, index) => index + 1));
    expect(end).toEqual({ done: 50, total: 50, failures: [{ id: "J7", text: "J7 is over" }] });
  });
  it("stops when asked, and says how far it came", async () => {
    const stop = new AbortController();
    const end = await doToAll(ids, async (id) => void (id === "J10" && stop.abort()), () => {}, stop.signal);
    expect(end.done).toBeGreaterThan(9);
    expect(end.done).toBeLessThan(16);
  });
  it("goes to jobs in states where it means something", () => {
    expect(statesFor({ kind: "retry" })).toEqual(["failed", "cancelled"]);
    expect(statesFor({ kind: "purge" })).toHaveLength(5);
    expect([clampPriority(120), clampPriority(-7.4)]).toEqual([100, -7]);
    expect([jobsText(1), jobsText(12345)]).toEqual(["1 job", "12,345 jobs"]);
  });
});
