import { describe, expect, it } from "vitest";

import type { ComparisonRow, Verdict } from "../api/types";
import { headline, mainVerdict } from "./headline";
import { memoryFront } from "./memory";

const rows = ["paths", "photons"].map((label) => ({ label, parameters: {} }) as ComparisonRow);
const verdict = (error: number, order: number[], close = false): Verdict => ({
  metric: "relative_mse", error, easiest: error, close, factor: null, arrived: order.map((row) => ({ row, seconds: 1 })), missing: [], text: "",
});

describe("the headline", () => {
  it("names who is ahead all the way, whatever the easy errors say", () => {
    expect(headline([verdict(0.1, [0, 1], true), verdict(0.01, [1, 0])], rows)).toEqual({ row: 1, text: "photons is better here" });
  });
  it("names no winner where there is none", () => {
    expect(headline([], rows)).toBeNull();
    expect(headline([verdict(0.1, [0, 1], true)], rows)!.text).toBe("Too close to call");
    expect(headline([verdict(0.1, [0, 1]), verdict(0.01, [0, 1], true)], rows)!.text).toContain("paths is ahead at first; at relative_mse 0.01");
  });
  it("says where one takes over from another", () => {
    const found = headline([verdict(0.1, [0, 1]), verdict(0.001, [1, 0])], rows)!;
    expect(found).toMatchObject({ row: 1 });
    expect(found.text).toContain("paths is first down to relative_mse 0.1, photons below that");
  });
  it("shows first what tells two apart", () => {
    const two = verdict(0.1, [0, 1]);
    expect(mainVerdict([two, verdict(0.01, [1])], null)).toBe(two);
    expect(mainVerdict([verdict(0.1, [0, 1], true), verdict(0.01, [1])], 1)!.error).toBe(0.01);
    expect(mainVerdict([two, verdict(0.05, [0, 1]), verdict(0.01, [0])], 0)!.error).toBe(0.05);
    expect(mainVerdict([], null)).toBeNull();
  });
});

describe("memory", () => {
  it("is worth it when nobody as small is as good", () => {
    const point = (row: number, bytes: number, error: number) => ({ row, name: "", bytes, error });
    expect(memoryFront([point(0, 10, 1), point(1, 5, 2), point(2, 20, 1), point(3, 20, 0.5)]).map((one) => one.row)).toEqual([1, 0, 3]);
  });
});
