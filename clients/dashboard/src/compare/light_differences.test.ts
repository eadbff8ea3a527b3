import { describe, expect, it } from "vitest";

import type { Job } from "../api/types";
import { lightDifferences } from "./light_differences";

const job = (parameters: Record<string, unknown>, more: Record<string, unknown> = {}, name = "path_tracing") =>
  ({ request: { scene: "box", method: { name, parameters }, ...more } }) as unknown as Job;

describe("settings that change the light", () => {
  it("are said where images differ in them", () => {
    expect(lightDifferences([job({ indirect_bounces: 3 }), job({ indirect_bounces: null }), job({ bounces: 254 }, {}, "svo_many_lights")])).toEqual([
      "bounces of indirect light: 3 in image 1; all in images 2, 3",
    ]);
    expect(lightDifferences([job({ clamp: 0.1, repay: false }), job({ clamp: 0.1, repay: true }), job({})])).toEqual([
      "the clamp of connections: 0.1 m² in image 1; nothing is lost in image 2",
    ]);
    expect(lightDifferences([job({}, { glass: "solid" }), job({}, { glass: "as_stored" })])).toEqual(["glass: solid in image 1; as the scene has it in image 2"]);
    expect(lightDifferences([job({}, { animation: "walk", time: 1.5 }), job({})])).toEqual(["the moment: walk, 1.5 s in image 1; at rest in image 2"]);
  });
  it("are not, where they are alike, not known, or no matter of light", () => {
    expect(lightDifferences([job({ indirect_bounces: 3, sampler: "sobol" }), job({ indirect_bounces: 3, sampler: "random" }), null])).toEqual([]);
    expect(lightDifferences([job({ indirect_bounces: 3 }), null])).toEqual([]);
    expect(lightDifferences([])).toEqual([]);
  });
});
