import { describe, expect, it } from "vitest";

import { LogScale } from "./log_figure";

describe("a logarithmic axis", () => {
  const scale = new LogScale([0.01, 100], [400, 0]);
  it("has equal steps for equal factors, there and back", () => {
    expect([0.01, 0.1, 1, 10, 100].map((value) => Math.round(scale.at(value)))).toEqual([400, 300, 200, 100, 0]);
    for (const value of [0.02, 0.5, 77]) expect(scale.valueAt(scale.at(value))).toBeCloseTo(value, 10);
  });
  it("holds what is beyond its ends at them, and what has no logarithm at the lower one", () => {
    expect([1e-9, 0, -3].map((value) => scale.at(value))).toEqual([400, 400, 400]);
    expect(scale.at(1e9)).toBe(0);
  });
});
