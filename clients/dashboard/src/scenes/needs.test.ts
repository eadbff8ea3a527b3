import { expect, it } from "vitest";

import { needsOf } from "./needs";

it("tells what there is in plain words, and what has none by name", () => {
  const texts = needsOf({ glossy: false, area_lights: true, diffuse: true, hair_and_fur: true }).map(({ text }) => text);
  expect(texts).toEqual(["Matte surfaces", "Glowing surfaces", "hair and fur"]);
  expect(needsOf(null)).toEqual([]);
});
