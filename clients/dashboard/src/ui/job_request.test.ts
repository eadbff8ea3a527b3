import { execFileSync } from "node:child_process";
import { describe, expect, it } from "vitest";

import { curlText, minimalRequest, pythonLiteral, pythonText, shellText } from "./job_request";
import type { JobRequest, Method } from "../api/types";

const methods = [
  {
    name: "photon_mapping",
    parameters: {
      type: "object",
      properties: { photons: { type: "integer", default: 200000 }, gather: { type: "string", default: "final" }, radius: { type: ["number", "null"], default: null } },
    },
  },
] as unknown as Method[];

const echo: JobRequest = {
  scene: "cornell-box",
  camera: { name: undefined, look_at: undefined, aperture: 0, focus_distance: undefined },
  image: { width: 64, height: 32, filter: "box" },
  method: { name: "photon_mapping", device: "cpu", parameters: { photons: 5, gather: "final", radius: null } },
  stop: { seconds: null, passes: 4, target: null },
  first_pass: 0,
  seed: 1,
  layers: [],
  reference: { method: { name: "photon_mapping", device: "cpu", parameters: { photons: 200000, gather: "direct" } }, stop: { passes: 9, seconds: null } },
  metrics: [],
  priority: 0,
  labels: {},
  environment: { image: "image:x", scale: 1, rotation: 0.5 },
  glass: "as_stored",
  time: 0,
};

describe("a request without its defaults", () => {
  it("says what is meant", () => {
    expect(minimalRequest(echo, methods)).toEqual({
      scene: "cornell-box",
      image: { width: 64, height: 32 },
      method: { name: "photon_mapping", parameters: { photons: 5 } },
      stop: { passes: 4 },
      reference: { method: { name: "photon_mapping", parameters: { gather: "direct" } }, stop: { passes: 9 } },
      environment: { image: "image:x", rotation: 0.5 },
    });
  });
  it("keeps what is other", () => {
    const camera = { look_at: { eye: [0, 1, 2] as [number, number, number], target: [0, 0, 0] as [number, number, number] }, aperture: 0.1 };
    const more = { ...echo, camera, seed: 7, priority: -3, labels: { a: "b" }, layers: ["depth"], reference: "job:J1", glass: "solid" };
    expect(minimalRequest(more, [])).toMatchObject({ camera, seed: 7, priority: -3, labels: { a: "b" }, layers: ["depth"], reference: "job:J1", glass: "solid" });
  });
  it("keeps the moment, and an animation's first moment apart from rest", () => {
    const moving = minimalRequest({ ...echo, animation: "walk", time: 1.5, shutter: 0.02 }, methods);
    expect(moving).toMatchObject({ animation: "walk", time: 1.5, shutter: 0.02 });
    const first = minimalRequest({ ...echo, animation: 0, time: 0, shutter: 0 }, methods);
    expect(first.animation).toBe(0);
    expect("time" in first || "shutter" in first).toBe(false);
    expect("animation" in minimalRequest({ ...echo, animation: null, time: 0, shutter: 0 }, methods)).toBe(false);
  });
});

describe("the lines that repeat it", () => {
  const request = { ...minimalRequest(echo, methods), labels: { who: `it's "me" $HOME \\n é` } };
  it("survive a shell", () => {
    expect(execFileSync("/bin/sh", ["-c", `printf %s ${shellText(JSON.stringify(request))}`]).toString()).toBe(JSON.stringify(request));
    const curl = curlText(request, "http://127.0.0.1:8080", true);
    expect(curl).toContain("curl -X POST http://127.0.0.1:8080/v1/jobs");
    expect(curl).toContain("Bearer $PHOTOND_TOKEN");
    expect(curlText(request, "http://x", false)).not.toContain("Bearer");
  });
  it("are Python", () => {
    const literal = pythonLiteral({ ...request, flag: true, none: null, list: [1, 2.5, "x"] });
    const script = `import json,sys; print(json.dumps(${literal}))`;
    const read: unknown = JSON.parse(execFileSync("python3", ["-c", script]).toString());
    expect(read).toEqual({ ...request, flag: true, none: null, list: [1, 2.5, "x"] });
    expect(pythonText(request, "http://127.0.0.1:8080")).toContain('client = Client("http://127.0.0.1:8080")');
  });
});
