import { describe, expect, it } from "vitest";

import type { Method } from "../api/types";
import { bouncesOf, unequalBounces, withBounces } from "./bounces";

const method = (name: string, parameter: string, value: number | null, maximum: number) =>
  ({ name, parameters: { type: "object", properties: { [parameter]: { type: "integer", default: value, minimum: 0, maximum } } } }) as unknown as Method;
const methods = [
  method("path_tracing", "indirect_bounces", null, 1e6),
  method("photon_splatting", "bounces", 1, 254),
  method("reflective_shadow_maps", "bounces", 1, 1),
];

describe("bounces of both sides", () => {
  it("are what is given, else the method's default", () => {
    expect(bouncesOf({ name: "path_tracing" }, methods)).toBe(Infinity);
    expect(bouncesOf({ name: "path_tracing", parameters: { indirect_bounces: 3 } }, methods)).toBe(3);
    expect(bouncesOf({ name: "photon_splatting" }, methods)).toBe(1);
    expect(bouncesOf({ name: "photon_splatting", parameters: { bounces: 0 } })).toBe(0);
    expect(bouncesOf({ name: "photon_splatting", parameters: { bounces: 254 } })).toBe(Infinity);
    expect(bouncesOf({ name: "unheard_of" }, methods)).toBeNull();
  });
  it("are set by the name the method has, as far as it can", () => {
    expect(withBounces({ name: "path_tracing", parameters: { sampler: "sobol" } }, 6, methods).parameters).toEqual({ sampler: "sobol", indirect_bounces: 6 });
    expect(withBounces({ name: "photon_splatting" }, 6, methods).parameters).toEqual({ bounces: 6 });
    expect(withBounces({ name: "reflective_shadow_maps" }, 6, methods).parameters).toEqual({ bounces: 1 });
    expect(withBounces({ name: "unheard_of" }, 6, methods)).toEqual({ name: "unheard_of" });
  });
  it("are told where they differ from the reference's", () => {
    const reference = { method: { name: "path_tracing" }, stop: { passes: 16 } };
    const entries = [
      { label: "paths", method: { name: "path_tracing" } },
      { label: "splats", method: { name: "photon_splatting" } },
      { label: "swept", method: { name: "photon_splatting" }, sweep: { bounces: [1, 2] } },
    ];
    expect(unequalBounces({ reference, entries }, methods)).toEqual(["splats follows indirect light for 1 bounce, the reference without end."]);
    expect(unequalBounces({ reference: "job:J1", entries }, methods)).toEqual([]);
    expect(unequalBounces({ reference: { ...reference, method: { name: "path_tracing", parameters: { indirect_bounces: 1 } } }, entries }, methods)).toEqual([
      "paths follows indirect light without end, the reference for 1 bounce.",
    ]);
  });
});
