import { describe, expect, it } from "vitest";

import { halfTable, kGreatestHalf } from "./half";

describe("half floats", () => {
  const half = halfTable();
  it("decodes normal numbers, of both signs", () => {
    expect([0x3c00, 0xbc00, 0x4000, 0x3555, 0x7bff].map((bits) => half[bits])).toEqual([1, -1, 2, Math.fround(0.333251953125), kGreatestHalf]);
  });
  it("decodes the smallest ones, which have no leading 1", () => {
    expect(half[0x0001]).toBe(2 ** -24);
    expect(half[0x03ff]).toBe(1023 * 2 ** -24);
    expect(half[0x0400]).toBe(2 ** -14);
  });
  it("keeps zeros' signs, infinities and NaN", () => {
    expect(Object.is(half[0x8000], -0)).toBe(true);
    expect(half[0x7c00]).toBe(Infinity);
    expect(half[0xfc00]).toBe(-Infinity);
    expect(half[0x7c01]).toBeNaN();
    expect(half[0xffff]).toBeNaN();
  });
  it("rises with the bits", () => {
    expect(half.subarray(1, 0x7c01).every((value, i) => value > half[i]!)).toBe(true);
  });
});
