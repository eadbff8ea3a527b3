import { describe, expect, it } from "vitest";

import { orbitOf } from "./orbit";
import { cameraIn, membersOf, viewIn } from "./view_url";

describe("views in addresses", () => {
  it("come back as they were written", () => {
    const view = { orbit: orbitOf({ eye: [1, 2, 3.5], target: [0, 0.5, -1], yfov: 0.8 }) };
    const members = membersOf(view);
    expect(members).toEqual({ camera: null, eye: "1,2,3.5", target: "0,0.5,-1", yfov: "0.8" });
    expect(membersOf(viewIn(members as Record<string, string>)!)).toEqual(members);
    expect(membersOf({ camera: "front" })).toEqual({ camera: "front", eye: null, target: null, yfov: null });
    expect(viewIn({ camera: "front" })).toEqual({ camera: "front" });
  });
  it("that cannot be are none", () => {
    expect(viewIn({})).toBeNull();
    expect(viewIn({ eye: "1,2", target: "0,0,0" })).toBeNull();
    expect(viewIn({ eye: "1,,3", target: "0,0,0" })).toBeNull();
    expect(viewIn({ eye: "1,2,3", target: "1,2,3" })).toBeNull();
    expect(viewIn({ eye: "1,2,inf", target: "0,0,0", camera: "front" })).toEqual({ camera: "front" });
  });
  it("leave a field of view out that cannot be", () => {
    expect(membersOf(viewIn({ eye: "0,0,5", target: "0,0,0", yfov: "7" })!).yfov).toBe("0.69");
  });
  it("are what a job's camera is", () => {
    expect(cameraIn({ camera: "front" })).toEqual({ name: "front" });
    expect(cameraIn({ scene: "cornell-box" })).toBeNull();
    expect(cameraIn({ eye: "0,0,5", target: "0,0,0", yfov: "1" })).toEqual({
      look_at: { eye: [0, 0, 5], target: [0, 0, 0], up: [0, 1, 0], yfov: 1 },
    });
  });
});
