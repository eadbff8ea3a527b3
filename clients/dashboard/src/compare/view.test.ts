import { describe, expect, it } from "vitest";

import { fitted, gridOf, imagePoint, nextZoom, panePoint, panned, placed, showing, zoomedAt, type View } from "./view";

const pane = { width: 801, height: 600 };
const image = { width: 1920, height: 1080 };

describe("the view of an image", () => {
  it("fits large images whole and small ones by whole pixels", () => {
    expect(fitted(image, pane)).toEqual({ zoom: 801 / 1920, centre: { x: 960, y: 540 } });
    expect(fitted({ width: 128, height: 100 }, pane).zoom).toBe(6);
  });
  it("puts corners on whole pixels, and averages to a whole number of them", () => {
    const box = placed(fitted(image, pane), image, pane);
    expect(box).toEqual({ x: 0, y: 75, width: 801, height: 451 });
    expect(placed({ zoom: 2.5, centre: { x: 10.3, y: 0 } }, { width: 3, height: 3 }, pane)).toEqual({ x: 375, y: 300, width: 7.5, height: 7.5 });
    expect(placed({ zoom: 1 / 64, centre: { x: 0, y: 0 } }, { width: 3, height: 3 }, pane).width).toBe(1);
  });
  it("goes between places of the pane and of the image", () => {
    const view: View = { zoom: 3, centre: { x: 100.2, y: 40.7 } };
    const at = panePoint(view, pane, { x: 99.5, y: 41.25 });
    const back = imagePoint(view, pane, at);
    expect([back.x, back.y]).toEqual([expect.closeTo(99.5, 9), expect.closeTo(41.25, 9)]);
    expect(imagePoint(view, pane, placed(view, image, pane))).toEqual({ x: 0, y: 0 });
  });
  it("zooms about the place under the cursor", () => {
    let view = fitted(image, pane);
    const at = { x: 700, y: 130 };
    const before = imagePoint(view, pane, at);
    for (const zoom of [1, 3.3, 8, 40]) {
      view = zoomedAt(view, pane, at, zoom);
      const now = imagePoint(view, pane, at);
      // The corner's rounding to a device pixel is all that it may move by, in the larger of the two views.
      expect(Math.abs(now.x - before.x)).toBeLessThan(0.5 / zoom + 0.5 / fitted(image, pane).zoom);
      expect(view.zoom).toBe(zoom);
    }
    expect(zoomedAt(view, pane, at, 1e9).zoom).toBe(128);
  });
  it("pans by device pixels, and not off the image", () => {
    expect(panned({ zoom: 2, centre: { x: 100, y: 100 } }, image, 10, -4).centre).toEqual({ x: 95, y: 102 });
    expect(panned({ zoom: 2, centre: { x: 100, y: 100 } }, image, 1e4, 1e4).centre).toEqual({ x: 0, y: 0 });
  });
  it("steps through stops", () => {
    expect([nextZoom(1, true), nextZoom(1, false), nextZoom(0.3, true), nextZoom(5, false), nextZoom(128, true)]).toEqual([2, 0.5, 0.5, 4, 128]);
  });
  it("follows a pixel that would leave the pane", () => {
    const view: View = { zoom: 10, centre: { x: 500, y: 500 } };
    expect(showing(view, pane, { x: 510, y: 490 })).toEqual(view);
    const moved = showing(view, pane, { x: 600, y: 500 });
    expect(moved.centre.x).toBeGreaterThan(560);
    expect(panePoint(moved, pane, { x: 600, y: 500 }).x).toBeLessThan(pane.width - 10);
    expect(moved.centre.y).toBe(500);
  });
});

describe("a grid of images", () => {
  it("takes the columns that show them largest, within the stage", () => {
    expect(gridOf(2, image, { width: 1600, height: 500 }).map((box) => box.y)).toEqual([0, 0]);
    expect(gridOf(2, image, { width: 400, height: 800 }).map((box) => box.x)).toEqual([0, 0]);
    const nine = gridOf(9, { width: 100, height: 100 }, { width: 902, height: 900 });
    expect(new Set(nine.map((box) => box.x)).size).toBe(3);
    for (const box of nine) expect(box.x + box.width <= 902 && box.y + box.height <= 900).toBe(true);
  });
});
