import { describe, expect, it } from "vitest";

import type { ReferenceFacts, Statistics } from "../api/types";
import { measuredOf, measuringText } from "./measured";

const facts = (more: Partial<ReferenceFacts>): ReferenceFacts => ({ passes: 64, warnings: [], notes: [], ...more });

describe("what was measured", () => {
  it("has the interval of what two films measured, and the reference's noise where that has a part", () => {
    const statistics = {
      error: { relative_mse: 0.1, rmse: null, smape: 0.2, channels: [1, 2, 3], levels: { low: 4 } },
      error_interval: { relative_mse: [0.05, 0.15], rmse: [0, 0.01] },
      reference_error: { relative_mse: 0.7, smape: 0.02 },
    } as unknown as Statistics;
    expect(measuredOf(statistics)).toEqual([
      { name: "relative mse", value: 0.1, interval: [0.05, 0.15], own: null },
      { name: "rmse", value: null, interval: [0, 0.01], own: null },
      { name: "smape", value: 0.2, interval: null, own: 0.02 },
      { name: "channels R", value: 1, interval: null, own: null },
      { name: "channels G", value: 2, interval: null, own: null },
      { name: "channels B", value: 3, interval: null, own: null },
      { name: "levels low", value: 4, interval: null, own: null },
    ]);
  });
  it("is nothing without a reference", () => expect(measuredOf({ error: null, reference_error: null } as Statistics)).toEqual([]));
});

describe("how it was measured", () => {
  it("is said in a sentence", () => {
    expect(measuringText(facts({ form: "two_films", confidence: 0.9, denominators: { relative_mse: "pixel" } }), false)).toBe(
      "Measured against two films of different seeds, whose noise drops out of mean squares; in brackets what it leaves open at 90 %.",
    );
    expect(measuringText(facts({ form: "film" }), true)).toBe("Measured against one film of 64 passes: its noise is a part of every error, as far as it is known in the last column.");
    expect(measuringText(facts({ form: "image", passes: null }), false)).toBe("Measured against one image: its noise is a part of every error, and not known.");
  });
  it("says what relative errors are relative to where that is unusual", () => {
    expect(measuringText(facts({ form: "two_films", denominators: { "indirect:relative_mse": "neighbours" } }), false)).toContain("relative to a pixel's neighbours");
  });
  it("claims nothing of results of before, and none without a reference", () => {
    expect(measuringText(facts({}), true)).toContain("one reference of 64 passes");
    expect(measuringText(null, false)).toBe("");
  });
});
