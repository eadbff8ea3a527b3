import { describe, expect, it } from "vitest";

import { memoryFront } from "./memory";

describe("memory", () => {
  it("is worth it when nobody as small is as good", () => {
    const point = (row: number, bytes: number, error: number) => ({ row, name: "", bytes, error });
    expect(memoryFront([point(0, 10, 1), point(1, 5, 2), point(2, 20, 1), point(3, 20, 0.5)]).map((one) => one.row)).toEqual([1, 0, 3]);
  });
});
