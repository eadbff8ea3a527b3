import { describe, expect, it } from "vitest";

import type { Job } from "../api/types";
import { layers } from "../api/vocabulary";
import { someLayers } from "../api/vocabulary.test_data";
import { filmsOf, layerChoices, sourceOfJob, unknownSource, usualReference, type Source } from "./sources";

layers.value = someLayers;

const job = (id: string, more: Partial<Job> = {}, request: Record<string, unknown> = {}): Source =>
  sourceOfJob({
    id, role: "render", state: "succeeded", passes_done: 1, seconds: 0.5, reference_job: null, ...more,
    request: { method: { name: "photon_mapping" }, image: { width: 64, height: 48 }, layers: ["normal"], labels: {}, ...request },
  } as unknown as Job);
const held = (...sources: Source[]): [string[], Map<string, Source>] => [sources.map((source) => source.name), new Map(sources.map((source) => [source.name, source]))];

describe("what the images are", () => {
  it("says a job in a line or two", () => {
    expect(job("J7")).toMatchObject({ name: "job:J7", title: "J7 photon mapping", detail: "1 pass, 500 ms, 64 × 48", size: { width: 64, height: 48 } });
    expect(job("J7", { state: "running", role: "reference" }, { labels: { name: "fine" } })).toMatchObject({
      title: "J7 photon mapping, fine (reference)",
      detail: "running, 1 pass, 500 ms, 64 × 48",
    });
  });
  it("takes as reference what a job was measured against, then a job of that role, then the first", () => {
    expect(usualReference(...held(job("J1"), job("J2"), job("J3", { reference_job: "J2" })))).toBe(1);
    expect(usualReference(...held(job("J1", {}, { reference: "job:J3" }), job("J2", { role: "reference" }), job("J3")))).toBe(2);
    expect(usualReference(...held(job("J1", { reference_job: "J9" }), job("J2", { role: "reference" })))).toBe(1);
  });
  it("has both films of a reference that is two", () => {
    const [, sources] = held(job("J1", { reference_job: "J8", reference_jobs: ["J8", "J9"] }), job("J2", { reference_job: "J7", reference_jobs: ["J7"] }));
    expect(["job:J8", "job:J9", "job:J7"].map((name) => filmsOf(name, sources))).toEqual([["job:J8", "job:J9"], ["job:J8", "job:J9"], null]);
    expect(usualReference(...held(job("J1"), job("J2")))).toBe(0);
  });
  it("lists layers with the images that have them", () => {
    const file = { ...unknownSource("image:abc"), size: { width: 64, height: 48 }, layers: ["beauty", "Diffuse"] };
    expect(layerChoices(...held(job("J1"), file))).toEqual([
      { name: "beauty", of: [0, 1] }, { name: "emitted", of: [0] }, { name: "direct", of: [0] }, { name: "indirect", of: [0] }, { name: "normal", of: [0] }, { name: "Diffuse", of: [1] },
    ]);
  });
});
