import { describe, expect, it } from "vitest";

import { kAtOnce, type SlowAnswer, SlowRequests } from "./slow_requests";

const answer: SlowAnswer = { status: 200, statusText: "OK", headers: [], body: new Blob([]) };
const never = new AbortController().signal;
const settle = () => new Promise((done) => setTimeout(done));

/** A line whose requests end when they are told to. */
function line() {
  const begun: string[] = [];
  const end = new Map<string, () => void>();
  const slow = new SlowRequests(
    ({ path }, stop) =>
      new Promise((done, fail) => {
        begun.push(path);
        end.set(path, () => done(answer));
        stop.addEventListener("abort", () => fail(stop.reason));
      }),
  );
  return { begun, end, ask: (path: string, stop = never) => slow.ask({ path, token: null }, stop) };
}

describe("SlowRequests", () => {
  it("sends few at once, first come first served", async () => {
    const { begun, end, ask } = line();
    const all = ["a", "b", "c", "d"].map((path) => ask(path));
    expect(begun).toEqual(["a", "b"].slice(0, kAtOnce));
    end.get("b")!();
    await settle();
    expect(begun).toEqual(["a", "b", "c"]);
    for (const path of ["a", "c"]) end.get(path)!();
    await settle();
    end.get("d")!();
    expect(await Promise.all(all)).toHaveLength(4);
  });

  it("gives the place of one that is stopped to the next", async () => {
    const { begun, ask } = line();
    const stops = ["a", "b", "c", "d"].map(() => new AbortController());
    const all = ["a", "b", "c", "d"].map((path, i) => ask(path, stops[i]!.signal).catch((failure: Error) => failure.name));
    stops[2]!.abort(); // waits
    stops[0]!.abort(); // is under way
    await settle();
    expect(begun).toEqual(["a", "b", "d"]);
    expect([await all[0], await all[2]]).toEqual(["AbortError", "AbortError"]);
  });

  it("goes on after one that failed", async () => {
    const begun: string[] = [];
    const slow = new SlowRequests(({ path }) => (begun.push(path), Promise.reject(new TypeError("nobody there"))));
    const all = ["a", "b", "c"].map((path) => slow.ask({ path, token: null }, never).catch(() => path));
    expect(await Promise.all(all)).toEqual(["a", "b", "c"]);
    expect(begun).toEqual(["a", "b", "c"]);
  });
});
