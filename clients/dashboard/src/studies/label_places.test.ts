import { expect, test } from "vitest";

import { labelPlaces } from "./label_places";

const kRoom = { x: 64, y: 24, width: 246, height: 252 };

test("a label stands beside its point, on the side with room for it", () => {
  const [right, left] = labelPlaces([{ x: 100, y: 100 }, { x: 290, y: 200 }], [80, 80], 14, kRoom);
  expect(right).toEqual({ x: 111, y: 93, width: 80, height: 14 });
  expect(left).toEqual({ x: 199, y: 193, width: 80, height: 14 });
});

test("no label lies over another, nor over a point, nor beyond the figure", () => {
  const points = [{ x: 150, y: 150 }, { x: 152, y: 151 }, { x: 155, y: 149 }, { x: 151, y: 156 }];
  const boxes = labelPlaces(points, [230, 120, 240, 60], 14, kRoom);
  boxes.forEach((box, i) => {
    expect(box.x).toBeGreaterThanOrEqual(kRoom.x);
    expect(box.x + box.width).toBeLessThanOrEqual(kRoom.x + kRoom.width);
    expect(box.y).toBeGreaterThanOrEqual(kRoom.y);
    expect(box.y + box.height).toBeLessThanOrEqual(kRoom.y + kRoom.height);
    for (const other of boxes.slice(i + 1)) expect(box.y + box.height <= other.y || other.y + other.height <= box.y || box.x + box.width <= other.x || other.x + other.width <= box.x).toBe(true);
    for (const { x, y } of points) expect(x > box.x && x < box.x + box.width && y > box.y && y < box.y + box.height).toBe(false);
  });
});
