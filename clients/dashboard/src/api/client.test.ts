import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";

import { askPatiently, Problem } from "./client";
import { startShared } from "./shared";

const problem = (status: number, retryAfter: string | null) =>
  new Response(JSON.stringify({ type: "/problems/unavailable", title: "not now", status, detail: "a job renders" }), {
    status,
    headers: retryAfter === null ? {} : { "Retry-After": retryAfter },
  });
const notYet = () => new Response(null, { status: 202, headers: { "Retry-After": "1", "Preference-Applied": "respond-async" } });

describe("askPatiently", () => {
  const answers: Response[] = [];
  const asked = vi.fn((_path: string, _init: RequestInit) => Promise.resolve(answers.shift()!));
  beforeEach(() => {
    vi.useFakeTimers();
    vi.stubGlobal("fetch", asked);
    for (const storage of ["sessionStorage", "localStorage"]) vi.stubGlobal(storage, { getItem: () => null });
    vi.stubGlobal("document", { hidden: true, addEventListener: () => {} });
    vi.stubGlobal("window", {}); // a browser without workers that tabs share
    startShared({ hear: () => {}, turn: () => {} });
    answers.length = 0;
    asked.mockClear();
  });
  afterEach(() => {
    vi.useRealTimers();
    vi.unstubAllGlobals();
  });

  it("asks again when the daemon says, and is never held by it", async () => {
    answers.push(problem(503, "5"), notYet(), new Response("picture"));
    const reply = askPatiently("/v1/scenes/a/thumbnail.png");
    await vi.advanceTimersByTimeAsync(4_900);
    expect(asked).toHaveBeenCalledTimes(1);
    await vi.advanceTimersByTimeAsync(200);
    expect(asked).toHaveBeenCalledTimes(2);
    await vi.advanceTimersByTimeAsync(1_000);
    expect(await (await reply).text()).toBe("picture");
    for (const [, init] of asked.mock.calls) expect(init).toMatchObject({ priority: "low", headers: { Prefer: "respond-async" } });
  });

  it("asks once where asking again does not help", async () => {
    for (const refusal of [problem(503, null), problem(404, null), problem(429, "1")]) {
      answers.push(refusal);
      await expect(askPatiently("/v1/scenes/a/thumbnail.png")).rejects.toBeInstanceOf(Problem);
    }
    expect(asked).toHaveBeenCalledTimes(3);
  });

  it("gives an answer that says there is nothing yet, and none is made", async () => {
    answers.push(new Response(null, { status: 202, headers: { "Retry-After": "1" } }));
    expect((await askPatiently("/v1/jobs/J1/preview.png")).status).toBe(202);
  });

  it("ends when nobody wants it any more", async () => {
    answers.push(problem(503, "5"), problem(503, "5"));
    let wanted = true;
    const reply = askPatiently("/a", undefined, () => !wanted).catch((failure: Error) => failure);
    await vi.advanceTimersByTimeAsync(1);
    wanted = false;
    await vi.advanceTimersByTimeAsync(5_000);
    expect(await reply).toBeInstanceOf(Problem);

    answers.push(problem(503, "5"));
    const stop = new AbortController();
    const aborted = askPatiently("/a", stop.signal).catch((failure: Error) => failure);
    await vi.advanceTimersByTimeAsync(1);
    stop.abort();
    expect(((await aborted) as Error).name).toBe("AbortError");
    expect(asked).toHaveBeenCalledTimes(3);
  });
});
