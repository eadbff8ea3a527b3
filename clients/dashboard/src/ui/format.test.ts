import { describe, expect, it } from "vitest";

import { bytesText, countText, numberText, secondsText, stopText } from "./format";

describe("numbers as people read them", () => {
  it("gives three digits and no needless exponent", () => {
    expect([0, 1, 0.12345, 1234.5, 99999, 1234567, 0.000012345, -2.5].map((x) => numberText(x))).toEqual([
      "0", "1", "0.123", "1,235", "99,999", "1.23e6", "1.23e−5", "-2.5",
    ]);
    expect(numberText(null)).toBe("–");
    expect(numberText(Infinity)).toBe("∞");
  });
  it("chooses the unit of a time", () => {
    expect([0, 5e-5, 0.0123, 3.14159, 119, 600, 4000, 1e6].map(secondsText)).toEqual([
      "0 s", "50 µs", "12.3 ms", "3.14 s", "119 s", "10 min", "1 h 7 min", "12 days",
    ]);
  });
  it("counts bytes in powers of 1000, as all of photond does", () => {
    expect([0, 999, 1000, 1536, 5e9].map(bytesText)).toEqual(["0 B", "999 B", "1 kB", "1.54 kB", "5 GB"]);
  });
  it("shortens counts only when that loses little", () => {
    expect([999, 9999, 12345, 5.5e7].map(countText)).toEqual(["999", "9999", "12.3 k", "55 M"]);
  });
  it("says every stop condition", () => {
    expect(stopText({ seconds: 10, passes: 64, target: { metric: "relative_mse", value: 0.001 } })).toBe(
      "64 passes or 10 s or relative_mse ≤ 0.001",
    );
    expect(stopText({ seconds: null, passes: null, target: null })).toBe("–");
  });
});
