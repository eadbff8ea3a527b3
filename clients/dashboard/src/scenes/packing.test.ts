import { describe, expect, it } from "vitest";

import { bodyOf, packed } from "./packing";

const dropped = (...paths: string[]) => paths.map((path) => ({ path, file: new File(["12345"], path.split("/").at(-1)!) }));
const summary = (...paths: string[]) => packed(dropped(...paths)).packages.map(({ name, mediaType, files }) => [name, mediaType, files.length]);

describe("dropped files", () => {
  it("are a scene for each .glb and each .zip", () => {
    expect(summary("lamp.glb", "Chair.GLB", "rooms.zip")).toEqual([
      ["lamp", "model/gltf-binary", 1],
      ["Chair", "model/gltf-binary", 1],
      ["rooms", "application/zip", 1],
    ]);
  });
  it("are one scene for a .gltf with its files, called as its folder when its own name says nothing", () => {
    expect(summary("lamp/scene.gltf", "lamp/scene.bin", "lamp/textures/wood.png", "lamp/.DS_Store")).toEqual([["lamp", "multipart/form-data", 3]]);
    expect(summary("desk.gltf", "desk.bin")[0]![0]).toBe("desk");
  });
  it("count their bytes", () => {
    expect(packed(dropped("a.gltf", "a.bin")).packages[0]!.bytes).toBe(10);
  });
  it("that are no scene are told of", () => {
    expect(packed(dropped("notes.txt")).faults[0]).toContain("notes.txt is not a scene");
    expect(packed(dropped("a.png", "b.png")).faults[0]).toContain("None of 2 files is a scene");
    expect(packed(dropped("a/a.gltf", "b/b.gltf")).faults[0]).toContain("2 .gltf files");
    expect(packed([]).faults[0]).toContain("no file");
    expect(packed(dropped("room.glb", "room.png"))).toMatchObject({ faults: [], packages: [{ name: "room" }] });
  });
});

it("a form carries each file under its path", () => {
  const [scene] = packed(dropped("lamp/lamp.gltf", "lamp/textures/wood.png")).packages;
  const { body, mediaType } = bodyOf(scene!);
  expect(mediaType).toBeNull();
  expect((body as FormData).getAll("file").map((file) => (file as File).name)).toEqual(["lamp/lamp.gltf", "lamp/textures/wood.png"]);
});
