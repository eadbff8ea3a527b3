import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";

import { askPatiently, Problem } from "./client";

const problem = (status: number, retryAfter: string | null) =>
  new Response(JSON.stringify({ type: "/problems/unavailable", title: "not now", status, detail: "a job renders" }), {
    status,
    headers: retryAfter === null ? {} : { "Retry-After": retryAfter },
  });

describe("askPatiently", () => {
  const answers: Response[] = [];
  const asked = vi.fn(() => Promise.resolve(answers.shift()!));
  beforeEach(() => {
    vi.useFakeTimers();
    vi.stubGlobal("fetch", asked);
    vi.stubGlobal("sessionStorage", { getItem: () => null });
    answers.length = 0;
    asked.mockClear();
  });
  afterEach(() => {
    vi.useRealTimers();
    vi.unstubAllGlobals();
  });

  it("asks again when the daemon says", async () => {
    answers.push(problem(503, "5"), problem(503, "5"), new Response("picture"));
    const reply = askPatiently("/v1/scenes/a/thumbnail.png");
    await vi.advanceTimersByTimeAsync(4_900);
    expect(asked).toHaveBeenCalledTimes(1);
    await vi.advanceTimersByTimeAsync(200);
    expect(asked).toHaveBeenCalledTimes(2);
    await vi.advanceTimersByTimeAsync(5_000);
    expect(await (await reply).text()).toBe("picture");
  });

  it("asks once where asking again does not help", async () => {
    for (const refusal of [problem(503, null), problem(404, null), problem(429, "1")]) {
      answers.push(refusal);
      await expect(askPatiently("/v1/scenes/a/thumbnail.png")).rejects.toBeInstanceOf(Problem);
    }
    expect(asked).toHaveBeenCalledTimes(3);
  });

  it("ends when nobody wants it any more", async () => {
    answers.push(problem(503, "5"), problem(503, "5"));
    let wanted = true;
    const reply = askPatiently("/a", {}, () => !wanted).catch((failure: Error) => failure);
    await vi.advanceTimersByTimeAsync(1);
    wanted = false;
    await vi.advanceTimersByTimeAsync(5_000);
    expect(await reply).toBeInstanceOf(Problem);

    answers.push(problem(503, "5"));
    const stop = new AbortController();
    const aborted = askPatiently("/a", { signal: stop.signal }).catch((failure: Error) => failure);
    await vi.advanceTimersByTimeAsync(1);
    stop.abort();
    expect(((await aborted) as Error).name).toBe("AbortError");
    expect(asked).toHaveBeenCalledTimes(3);
  });
});
