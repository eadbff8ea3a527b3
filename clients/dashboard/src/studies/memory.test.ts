import { describe, expect, it } from "vitest";

import type { ComparisonRow } from "../api/types";
import { memoryFront, memoryPoints } from "./memory";

describe("memory", () => {
  it("is worth it when nobody as small is as good", () => {
    const point = (row: number, bytes: number, error: number) => ({ row, name: "", bytes, error, isBound: false });
    expect(memoryFront([point(0, 10, 1), point(1, 5, 2), point(2, 20, 1), point(3, 20, 0.5)]).map((one) => one.row)).toEqual([1, 0, 3]);
  });
  it("is against the error, or its upper bound", () => {
    const row = (value: number | null, interval: [number, number] | null = null) => ({ label: "", parameters: {}, peak_bytes: 8, error: { rmse: { value, interval } } }) as unknown as ComparisonRow;
    const points = memoryPoints([row(0.5), row(-0.1, [-0.3, 0.1]), row(null), row(-0.1)], "rmse", new Set());
    expect(points.map((one) => [one.row, one.error, one.isBound])).toEqual([[0, 0.5, false], [1, 0.1, true]]);
  });
});
