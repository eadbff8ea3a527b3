import { describe, expect, it } from "vitest";

import type { BiasAndVariance, ComparisonReport, ComparisonRow } from "../api/types";
import { layers } from "../api/vocabulary";
import { someLayers } from "../api/vocabulary.test_data";
import { biasLines, biasText, floorsOf, layerOf, mapLayers, varianceText } from "./bias";

const bias = (more: Partial<BiasAndVariance> = {}): BiasAndVariance => ({
  squared_bias: 0.002, low: 0.001, high: 0.003, variance: 0.01, variance_low: 0.008, variance_high: 0.02, floor: true, text: "", ...more,
});
const row = (label: string, told: BiasAndVariance | null) => ({ label, parameters: {}, seeds: 3, bias: told && { relative_mse: told } }) as unknown as ComparisonRow;

describe("bias", () => {
  it("is a floor where it does not shrink and is told apart from 0", () => {
    const rows = [row("a", bias()), row("b", bias({ floor: false })), row("c", bias({ low: -0.001 })), row("d", null), row("e", bias({ squared_bias: 0.5, low: 0.4 }))];
    expect(floorsOf(rows, "relative_mse")).toEqual([{ row: 0, name: "a", error: 0.001 }, { row: 4, name: "e", error: 0.4 }]);
    expect(floorsOf(rows, "rmse")).toEqual([]);
    expect(biasLines(rows, "relative_mse").map((line) => line.row)).toEqual([0, 1, 2, 4]);
  });
  it("is said with its interval, and variance too where there is one", () => {
    expect([biasText(bias()), varianceText(bias())]).toEqual(["0.002 (0.001 to 0.003)", "0.01 (0.008 to 0.02)"]);
    expect(biasText(bias({ squared_bias: -0.001, low: -0.004 }))).toBe("below 0.003 (not told apart from 0)");
    expect(varianceText(bias({ variance_low: null, variance_high: null }))).toBe("0.01");
  });
  it("has maps of the layers of light, at first of the metric's own", () => {
    layers.value = someLayers;
    expect(mapLayers({ request: { layers: ["normal", "depth"] } } as unknown as ComparisonReport)).toEqual(["beauty", "emitted", "direct", "indirect"]);
    expect([layerOf("indirect:relative_mse"), layerOf("rmse")]).toEqual(["indirect", "beauty"]);
  });
});
