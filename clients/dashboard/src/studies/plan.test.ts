import { describe, expect, it } from "vitest";

import type { Method } from "../api/types";
import { defaultPlan, entryOf, faultsUnder, labelsOf, planOf, readPlan, requestOf, valuesOf } from "./plan";

const methods = [{ name: "path_tracing", title: "Path tracing" }, { name: "photon_mapping", title: "Photon mapping" }] as Method[];

describe("a plan", () => {
  it("is a whole request from the start", () => {
    const request = requestOf(defaultPlan(), methods);
    expect(request).toMatchObject({
      scene: "cornell-box", image: { width: 256, height: 256 }, stop: { seconds: 10 }, seeds: [1],
      reference: { method: { name: "path_tracing", device: "cpu" }, stop: { passes: 1024 } },
    });
    expect(request.entries.map((entry) => entry.method.name)).toEqual(["path_tracing", "photon_mapping", "photon_splatting"]);
  });
  it("comes back from its request, with what the form does not show", () => {
    const request = {
      ...requestOf(defaultPlan("keyhole"), methods),
      image: { width: 10, height: 20, filter: "box" },
      reference: "job:J3",
      entries: [{ label: "a", method: { name: "photon_mapping" }, sweep: { photons: [10, 20], gather: ["direct", "final"] } }],
      stop: { passes: 5 },
      seeds: [3, 4],
      labels: { project: "x" },
      glass: null,
    };
    const { glass: _, ...rest } = request;
    expect(requestOf(planOf(request), methods)).toEqual(rest);
  });
  it("names entries apart", () => {
    const plan = { ...defaultPlan(), entries: [entryOf({ name: "path_tracing" }), entryOf({ name: "path_tracing" }), entryOf({ name: "path_tracing" }, "mine")] };
    expect(labelsOf(plan, methods)).toEqual(["path tracing", "path tracing 2", "mine"]);
  });
  it("survives the session, and nonsense in it", () => {
    const plan = defaultPlan();
    expect(requestOf(readPlan(JSON.stringify(plan))!, methods)).toEqual(requestOf(plan, methods));
    for (const text of [null, "", "{", "{}", '{"scene":1}']) expect(readPlan(text)).toBeNull();
  });
});

describe("lists as typed", () => {
  it("are numbers, words and truths", () => {
    expect(valuesOf("1000, 5e3; 0.5  direct true")).toEqual([1000, 5000, 0.5, "direct", true]);
    expect(valuesOf(" , ")).toEqual([]);
  });
});

describe("faults", () => {
  it("are found by where they are", () => {
    const faults = [{ pointer: "/entries/1/method/parameters/photons", detail: "a" }, { pointer: "/entries/10/label", detail: "b" }, { pointer: "/entries/1", detail: "c" }];
    expect(faultsUnder(faults, "/entries/1")).toEqual([{ pointer: "/method/parameters/photons", detail: "a" }, { pointer: "", detail: "c" }]);
  });
});
