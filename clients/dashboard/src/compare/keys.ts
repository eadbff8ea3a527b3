// What can be done by keys.

import { isMeasured } from "../api/vocabulary";
import type { Key } from "../app/keyboard";
import { autoExposureStops } from "./auto_exposure";
import { addCrop } from "./crop_strip";
import type { Desk } from "./desk";
import { kChannels, kCurves, kErrors, kFalseColours, kMaxImages, type Look } from "./look";
import { toggleCursor } from "./readout";
import { kExposureStep, zoomBy, zoomTo } from "./toolbar";
import { clamp, panned, showing } from "./view";

const kPan = 64;
const kFarPan = 512;
const kFarPixels = 10;
const kWipe = 0.02;

const after = <Value>(values: readonly Value[], value: Value, by: number): Value => {
  const at = Math.max(0, values.indexOf(value));
  return values[(at + by + values.length) % values.length]!;
};

export function compareKeys(desk: Desk): Key[] {
  const look = (): Look => desk.look.peek();
  const show = (index: number) => {
    if (index < look().images.length) desk.change({ shown: index });
  };
  let before = 0;
  const flipTo = (index: number) => {
    if (index !== look().shown) before = look().shown;
    show(index);
  };
  const cycle = <Name extends "channel" | "curve" | "colours">(name: Name, values: readonly Look[Name][], by: number) =>
    desk.change({ [name]: after(values, look()[name], by) } as unknown as Partial<Look>);
  const autoExpose = () => {
    const image = desk.pixels(look().shown);
    const stops = image && autoExposureStops(image);
    if (stops !== null) desk.change({ exposure: stops });
  };
  const errors = () => kErrors.filter((kind) => !kind.startsWith("flip") || isMeasured(look().layer));
  const layers = () => desk.layers.peek().map((layer) => layer.name);

  function move(dx: number, dy: number, far: boolean): void {
    const pixel = look().pixel;
    if (desk.cursorOn.peek() && pixel) {
      const step = far ? kFarPixels : 1;
      const size = desk.size.peek();
      const next = { x: clamp(pixel.x + dx * step, 0, size.width - 1), y: clamp(pixel.y + dy * step, 0, size.height - 1) };
      desk.hovered.value = null;
      desk.change({ pixel: next });
      if (look().zoom !== null) desk.setView(showing(desk.view.peek(), desk.paneSize.peek(), next));
      return;
    }
    const by = (far ? kFarPan : kPan) * desk.density.peek();
    desk.setView(panned(desk.view.peek(), desk.size.peek(), -dx * by, -dy * by));
  }

  const arrows: [string, number, number][] = [["ArrowLeft", -1, 0], ["ArrowRight", 1, 0], ["ArrowUp", 0, -1], ["ArrowDown", 0, 1]];
  return [
    ...Array.from({ length: kMaxImages }, (_, i) => ({ key: String(i + 1), text: "show the image of this number", run: () => flipTo(i) })),
    { key: "0", text: "show the reference", run: () => flipTo(desk.reference.peek()) },
    { key: "`", text: "back to the image shown before", run: () => flipTo(before) },
    { key: "[", text: "the image before, after", run: () => flipTo((look().shown + look().images.length - 1) % look().images.length) },
    { key: "]", text: "the image before, after", run: () => flipTo((look().shown + 1) % look().images.length) },
    { key: "r", text: "make the image shown the reference", run: () => desk.change({ reference: look().images[look().shown] ?? null }) },
    { key: "v", text: "one image", run: () => desk.change({ mode: "single" }) },
    { key: "w", text: "wipe between two", run: () => desk.change({ mode: "wipe" }) },
    { key: "b", text: "two side by side", run: () => desk.change({ mode: "side" }) },
    { key: "a", text: "all in a grid", run: () => desk.change({ mode: "grid" }) },
    { key: ",", text: "move the wipe", run: () => desk.change({ wipe: clamp(look().wipe - kWipe, 0, 1) }) },
    { key: ".", text: "move the wipe", run: () => desk.change({ wipe: clamp(look().wipe + kWipe, 0, 1) }) },
    { key: "h", text: "turn the wipe", run: () => desk.change({ wipeAcross: !look().wipeAcross }) },
    ...arrows.flatMap(([key, dx, dy]) => [
      { key, text: "move the pictures, or the pixel", run: () => move(dx, dy, false) },
      { key: `Shift+${key}`, text: "move them far", run: () => move(dx, dy, true) },
    ]),
    { key: "+", text: "zoom", run: () => zoomBy(desk, true) },
    { key: "=", text: "zoom", run: () => zoomBy(desk, true) },
    { key: "-", text: "zoom", run: () => zoomBy(desk, false) },
    { key: "z", text: "pixel for pixel", run: () => zoomTo(desk, 1) },
    { key: "f", text: "fit the image into its pane", run: () => desk.fit() },
    { key: "x", text: "exposure half a stop up, down", run: () => desk.change({ exposure: clamp(look().exposure + kExposureStep, -30, 30) }) },
    { key: "X", text: "exposure half a stop up, down", run: () => desk.change({ exposure: clamp(look().exposure - kExposureStep, -30, 30) }) },
    { key: "A", text: "exposure by the image shown", run: () => autoExpose() },
    { key: "m", text: "next false colours", run: () => cycle("colours", kFalseColours, 1) },
    { key: "t", text: "next view transform", run: () => cycle("curve", kCurves, 1) },
    { key: "c", text: "next channel", run: () => cycle("channel", kChannels, 1) },
    { key: "l", text: "next, previous layer", run: () => desk.change({ layer: after(layers(), look().layer, 1) }) },
    { key: "L", text: "next, previous layer", run: () => desk.change({ layer: after(layers(), look().layer, -1) }) },
    { key: "e", text: "next, previous kind of error map", run: () => desk.change({ error: after(errors(), look().error, 1) }) },
    { key: "E", text: "next, previous kind of error map", run: () => desk.change({ error: after(errors(), look().error, -1) }) },
    { key: "p", text: "read the pixel that arrow keys move", run: () => toggleCursor(desk) },
    { key: "d", text: "draw a crop", run: () => (desk.cropping.value = !desk.cropping.peek()) },
    { key: "k", text: "put a crop here", run: () => addCrop(desk) },
    {
      key: "Escape",
      text: "read no pixel, draw no crop",
      run: () => {
        desk.cursorOn.value = false;
        desk.cropping.value = false;
        desk.change({ pixel: null });
      },
    },
  ];
}
