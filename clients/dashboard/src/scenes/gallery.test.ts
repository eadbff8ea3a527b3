import { describe, expect, it } from "vitest";

import type { Scene } from "../api/types";
import { factsText, found, ordered } from "./gallery";

const scene = (id: string, members: Partial<Scene> = {}) =>
  ({ id, name: id, triangles: 10, materials: 1, bytes: 0, lights: { area: 2, punctual: 0, environment: false }, ...members }) as Scene;
const scenes = [scene("cornell-box", { triangles: 32 }), scene("a1b2", { name: "Lamp 10", bytes: 9 }), scene("c3d4", { name: "lamp 9" })];
const names = (list: Scene[]) => list.map(({ name }) => name);

describe("the gallery", () => {
  it("finds by words of the name or id", () => {
    expect(names(found(scenes, "LAMP"))).toEqual(["Lamp 10", "lamp 9"]);
    expect(names(found(scenes, "9 lamp"))).toEqual(["lamp 9"]);
    expect(names(found(scenes, "a1"))).toEqual(["Lamp 10"]);
    expect(found(scenes, "  ")).toHaveLength(3);
  });
  it("orders names as people count", () => {
    expect(names(ordered(scenes, "name"))).toEqual(["cornell-box", "lamp 9", "Lamp 10"]);
    expect(names(ordered(scenes, "triangles"))[0]).toBe("cornell-box");
    expect(names(ordered(scenes, "bytes"))[0]).toBe("Lamp 10");
    expect(ordered(scenes, "listed")).toBe(scenes);
  });
  it("tells what is in a scene", () => {
    expect(factsText(scenes[0]!)).toBe("32 triangles, 1 material, area lights");
    expect(factsText(scene("x", { triangles: 1, lights: { area: 0, punctual: 1, environment: true } }))).toBe("1 triangle, 1 material, 1 lamp and a sky");
    expect(factsText(scene("x", { lights: { area: 0, punctual: 0, environment: false } }))).toContain("no light");
  });
});
