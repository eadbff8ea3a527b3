import { describe, expect, it } from "vitest";

import type { BiasAndVariance, ComparisonReport, ComparisonRow } from "../api/types";
import { layers } from "../api/vocabulary";
import { someLayers } from "../api/vocabulary.test_data";
import { awaitsBias, biasLines, biasText, floorsOf, layerOf, mapLayers, varianceText } from "./bias";

const bias = (more: Partial<BiasAndVariance> = {}): BiasAndVariance => ({
  squared_bias: 0.002, low: 0.001, high: 0.003, variance: 0.01, variance_low: 0.008, variance_high: 0.02, floor: true, text: "", ...more,
});
const row = (label: string, told: BiasAndVariance | null) => ({ label, parameters: {}, seeds: 3, bias: told && { relative_mse: told } }) as unknown as ComparisonRow;

describe("bias", () => {
  it("is a floor where it does not shrink and is told apart from 0", () => {
    const rows = [row("a", bias()), row("b", bias({ floor: false })), row("c", bias({ low: -0.001 })), row("d", null), row("e", bias({ squared_bias: 0.5, low: 0.4 }))];
    expect(floorsOf(rows, "relative_mse")).toEqual([{ row: 0, name: "a", error: 0.001 }, { row: 4, name: "e", error: 0.4 }]);
    expect(floorsOf(rows, "smape")).toEqual([]);
    const roots = [{ ...rows[0]!, bias: { "indirect:mse": bias({ low: 0.04, squared_bias: 0.05 }), mse: bias() } }];
    expect(floorsOf(roots, "indirect:rmse")).toEqual([{ row: 0, name: "a", error: 0.2 }]);
    expect(floorsOf(roots, "fitted_rmse")).toEqual([]);
    expect(biasLines(roots, "rmse")).toHaveLength(1);
    expect(biasLines(rows, "relative_mse").map((line) => line.row)).toEqual([0, 1, 2, 4]);
  });
  it("is said with its interval, and variance too where there is one", () => {
    expect([biasText(bias()), varianceText(bias())]).toEqual(["0.002 (0.001 to 0.003)", "0.01 (0.008 to 0.02)"]);
    expect(biasText(bias({ squared_bias: -0.001, low: -0.004 }))).toBe("below 0.003 (not told apart from 0)");
    expect(varianceText(bias({ variance_low: null, variance_high: null }))).toBe("0.01");
  });
  it("is awaited where it is to come, of a study that is over", () => {
    const report = (state: string, form: string, seeds: number, succeeded = seeds) =>
      ({ state, reference: { form }, table: [{ ...row("a", null), seeds, succeeded }] }) as unknown as ComparisonReport;
    expect(awaitsBias(report("succeeded", "two_films", 2))).toBe(true);
    expect([report("running", "two_films", 2), report("succeeded", "film", 2), report("succeeded", "two_films", 1), report("failed", "two_films", 2, 1)].map(awaitsBias)).toEqual([false, false, false, false]);
    expect(awaitsBias({ ...report("succeeded", "two_films", 2), table: [row("a", bias())] } as ComparisonReport)).toBe(false);
  });
  it("has maps of the layers of light, at first of the metric's own", () => {
    layers.value = someLayers;
    expect(mapLayers({ request: { layers: ["normal", "depth"] } } as unknown as ComparisonReport)).toEqual(["beauty", "emitted", "direct", "indirect"]);
    expect([layerOf("indirect:relative_mse"), layerOf("rmse")]).toEqual(["indirect", "beauty"]);
  });
});
