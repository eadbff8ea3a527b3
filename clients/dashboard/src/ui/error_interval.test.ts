import { describe, expect, it } from "vitest";

import { drawnError, errorNowText, errorWithInterval, shortError } from "./error_interval";

describe("an error with its interval", () => {
  it("is the value and what its reference's noise leaves open", () => {
    expect(errorWithInterval(0.0012, [0.0008, 0.0016])).toBe("0.0012 (0.0008 to 0.0016)");
    expect(errorWithInterval(0.0012, [-0.0004, 0.0028])).toBe("0.0012 (-0.0004 to 0.0028)");
    expect(shortError(0.0012, [0.0008, 0.0016])).toBe("0.0012");
  });
  it("is an upper bound where the value is 0 or less, or the root of such a one", () => {
    for (const value of [-0.001, 0, null]) {
      expect(errorWithInterval(value, [-0.006, 0.004])).toBe("below 0.004 (not told apart from 0)");
      expect(shortError(value, [-0.006, 0.004])).toBe("below 0.004");
    }
  });
  it("is known to half the width of an interval that lies below 0 by luck", () => {
    expect(errorWithInterval(-0.002, [-0.003, -0.001])).toBe("below 0.001 (not told apart from 0)");
    expect(shortError(-0.002, [-0.004, -0.001])).toBe("below 0.0015");
    expect(errorWithInterval(0, [0, 0])).toBe("0");
  });
  it("is the value alone where no interval is known", () => {
    expect(errorWithInterval(0.5, null)).toBe("0.5");
    expect(errorWithInterval(-0.5, undefined)).toBe("-0.5"); // such as a bias, which has a sign
    expect(errorWithInterval(null, null)).toBe("–");
  });
  it("stands in lists with its metric", () => {
    expect(errorNowText({ metric: "relative_mse", value: 0.5 })).toBe("0.5 relative mse");
    expect(errorNowText({ metric: "rmse", value: null, interval: [0, 0.02] })).toBe("below 0.02 rmse");
    expect(errorNowText({ metric: "rmse", value: null })).toBe("");
    expect(errorNowText(null)).toBe("");
  });
});

describe("an error on a logarithmic axis", () => {
  it("stands at its value, or at the upper end of what it may be", () => {
    expect(drawnError(0.5, [0.4, 0.6])).toEqual({ at: 0.5, isBound: false, least: 0.4, greatest: 0.6 });
    expect(drawnError(-0.5, [-1.1, 0.1])).toEqual({ at: 0.1, isBound: true, least: -1.1, greatest: 0.1 });
    expect(drawnError(null, [0, 0.1])).toEqual({ at: 0.1, isBound: true, least: 0, greatest: 0.1 });
    expect(drawnError(0.5, null)).toEqual({ at: 0.5, isBound: false, least: 0.5, greatest: 0.5 });
  });
  it("is known to half the width of an interval that lies below 0 by luck", () => {
    expect(drawnError(-0.5, [-0.75, -0.25])).toEqual({ at: 0.25, isBound: true, least: -0.75, greatest: 0.25 });
  });
  it("has no place where nothing of it is above 0", () => {
    for (const value of [-0.5, 0, null, undefined, NaN, Infinity]) expect(drawnError(value, null)).toBeNull();
    expect(drawnError(0, [0, 0])).toBeNull();
  });
});
