import { describe, expect, it } from "vitest";

import { scrollIntoView, scrollTopOf, windowOf } from "./window";

describe("rows in view", () => {
  it("are those of the place scrolled to, and a few more", () => {
    const window = windowOf(100_000, 36, 36 * 500, 720);
    expect(window).toMatchObject({ first: 492, last: 528, top: 500, height: 3_600_000 });
    expect(window.offset).toBe(492 * 36);
  });
  it("end with the list", () => {
    expect(windowOf(3, 36, 0, 720)).toMatchObject({ first: 0, last: 2, offset: 0, height: 108 });
    expect(windowOf(0, 36, 0, 720)).toMatchObject({ last: -1, height: 0 });
  });
  it("are reached in a list higher than an element may be", () => {
    const rows = 2_000_000;
    const end = windowOf(rows, 36, 12_000_000 - 720, 720);
    expect(end.height).toBe(12_000_000);
    expect(end.last).toBe(rows - 1);
    // The last row's lower edge is the list's.
    expect(end.offset + (rows - end.first) * 36).toBeCloseTo(12_000_000, 3);
    expect(windowOf(rows, 36, scrollTopOf(1_234_567, rows, 36, 720), 720).top).toBe(1_234_567);
  });
  it("come into view by the least scrolling", () => {
    expect(scrollIntoView(505, 1000, 36, 36 * 500, 720)).toBeNull();
    expect(scrollIntoView(499, 1000, 36, 36 * 500, 720)).toBe(36 * 499);
    expect(scrollIntoView(520, 1000, 36, 36 * 500, 720)).toBe(36 * 501);
    expect(scrollIntoView(520, 1000, 36, 36 * 500, 730)).toBe(36 * 521 - 730);
  });
});
