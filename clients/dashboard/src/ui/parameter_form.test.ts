import { describe, expect, it } from "vitest";

import type { Device, Method } from "../api/types";
import {
  changedParameters,
  choiceOf,
  defaultText,
  exactText,
  faultOf,
  fieldsOf,
  groupsOf,
  localFaults,
  rangeText,
  typedText,
  valueOfText,
  withParameter,
} from "./parameter_form";

const method: Method = {
  name: "photon_mapping",
  title: "Photon mapping",
  family: "photon mapping",
  devices: ["cpu"],
  sources: ["Jensen 1996"],
  mergeable: true,
  deterministic: { cpu: true },
  parameters: {
    type: "object",
    properties: {
      gather: { type: "string", enum: ["direct", "final"], default: "final", "x-group": "Light" },
      photons: { type: "integer", default: 200000, minimum: 1, maximum: 1e9, "x-unit": "photons", "x-group": "Light" },
      radius: { type: ["number", "null"], default: null, minimum: 1e-9, maximum: 1e9, "x-unit": "m", "x-group": "Density" },
      soft_disc: { type: "boolean", default: false, "x-group": "Density" },
      brand_new: { type: "number", default: 0.5, minimum: 0, maximum: 1, "x-unit": "" },
    },
    "x-order": ["radius", "photons", "gather", "soft_disc", "brand_new"],
    "x-groups": ["Light", "Splats", "Density"],
  },
};
const [radius, photons, gather, softDisc] = fieldsOf(method) as [never, never, never, never];

describe("fields made from a schema", () => {
  it("come as declared, with their types", () => {
    expect(fieldsOf(method).map(({ name, type, optional }) => [name, type, optional])).toEqual([
      ["radius", "number", true],
      ["photons", "integer", false],
      ["gather", "string", false],
      ["soft_disc", "boolean", false],
      ["brand_new", "number", false],
    ]);
  });
  it("say range, unit and default", () => {
    expect(rangeText(photons)).toBe("1 to 1e9 photons");
    expect([photons, gather, radius, softDisc].map(defaultText)).toEqual(["200000", "final", "not given", "no"]);
  });
  it("are in the groups of the schema, in its order, the unsorted last", () => {
    expect(groupsOf(method).map(({ title, fields }) => [title, fields.map((field) => field.name)])).toEqual([
      ["Light", ["photons", "gather"]],
      ["Density", ["radius", "soft_disc"]],
      ["Other", ["brand_new"]],
    ]);
  });
});

describe("numbers in messages", () => {
  // As std::to_chars() writes them.
  it("are the shortest the daemon knows", () => {
    expect([1e9, 0.5, 64, 100000, 12345, 1e-9, 0.03, -10000, 0].map(exactText)).toEqual([
      "1e+09", "0.5", "64", "1e+05", "12345", "1e-09", "0.03", "-10000", "0",
    ]);
  });
  it("are written plainly in fields", () => {
    expect([1e9, 200000, 0.00002, 1e-9].map(typedText)).toEqual(["1e9", "200000", "0.00002", "1e-9"]);
  });
});

describe("checks", () => {
  it("speak the daemon's words", () => {
    expect(faultOf(photons, 0)).toBe("0 is outside [1, 1e+09] photons");
    expect(faultOf(photons, 2e9)).toBe("2000000000 is outside [1, 1e+09] photons");
    expect(faultOf(photons, 1.5)).toBe("must be a whole number, got 1.5");
    expect(faultOf(photons, "many")).toBe('must be a whole number, got "many"');
    expect(faultOf(photons, null)).toBe("must be a whole number, got null");
    expect(faultOf(radius, null)).toBeNull();
    expect(faultOf(radius, 0)).toBe("0 is outside [1e-09, 1e+09] m");
    expect(faultOf(gather, "finall")).toBe('must be one of "direct", "final", got "finall"');
    expect(faultOf(softDisc, "yes")).toBe('must be true or false, got "yes"');
    expect(faultOf(photons, 1e9)).toBeNull();
  });
  it("point at the parameter", () => {
    expect(localFaults(method, { name: method.name, parameters: { photons: 0, gather: "direct", nothing: 1 } })).toEqual([
      { pointer: "/parameters/photons", detail: "photons: 0 is outside [1, 1e+09] photons" },
      { pointer: "/parameters/nothing", detail: "nothing: unknown parameter" },
    ]);
  });
  it("tell numbers from what is none", () => {
    expect(["", " 12 ", "1e6", "0.5", "abc", "0x10", "1,5", "Infinity"].map(valueOfText)).toEqual([
      undefined, 12, 1e6, 0.5, "abc", "0x10", "1,5", "Infinity",
    ]);
  });
});

describe("what a request says", () => {
  it("is only what differs from the default", () => {
    expect(withParameter({ gather: "direct" }, photons, 5)).toEqual({ gather: "direct", photons: 5 });
    expect(withParameter({ gather: "direct", photons: 5 }, photons, 200000)).toEqual({ gather: "direct" });
    expect(withParameter({ radius: 0.1 }, radius, null)).toEqual({});
    expect(withParameter({ photons: 5 }, photons, undefined)).toEqual({});
  });
  it("leaves a job's echo of defaults out", () => {
    expect(changedParameters(method, { photons: 200000, gather: "direct", radius: null, soft_disc: false })).toEqual({ gather: "direct" });
  });
  it("keeps the device where the method runs on it", () => {
    const gpu: Device = { id: "gpu:0", kind: "gpu", name: "A card", driver: null, memory_bytes: null, software: false, state: "ready" };
    const cpu: Device = { ...gpu, id: "cpu", kind: "cpu" };
    expect(choiceOf(method, [cpu, gpu], "gpu").device).toBe("cpu");
    expect(choiceOf({ ...method, devices: ["cpu", "gpu"] }, [cpu, gpu], "gpu").device).toBe("gpu");
    expect(choiceOf({ ...method, devices: ["gpu"] }, [cpu], "cpu").device).toBe("gpu");
  });
});
