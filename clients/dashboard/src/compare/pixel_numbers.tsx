// Each pixel's values written on it, once pixels are large enough to hold them.

import { useEffect, useRef } from "preact/hooks";

import type { Desk } from "./desk";
import type { Picture } from "./gl_develop";
import { relativeError, signedError } from "./paint";
import { pixelAt } from "./pixels";
import { imagePoint, panePoint } from "./view";

/** Device-independent pixels of a side from which values are legible. */
const kLegible = 56;

const shortText = (value: number): string =>
  Number.isNaN(value) ? "NaN" : !Number.isFinite(value) ? (value > 0 ? "∞" : "−∞") : Math.abs(value) >= 1e4 || (value !== 0 && Math.abs(value) < 1e-3) ? value.toExponential(1) : value.toPrecision(3);

/** What the pixel's colour is of: its channels, or its error. */
function valuesOf({ image, reference, paint }: Picture, x: number, y: number): number[] {
  const pixel = pixelAt(image, x, y) ?? [];
  const against = reference && pixelAt(reference, x, y);
  if (!against || paint.quantity === "pixel") return pixel;
  return [paint.quantity === "signed" ? signedError(pixel, against, paint.channel) : relativeError(pixel, against, paint.channel, paint.floor)];
}

export function PixelNumbers({ desk }: { desk: Desk }) {
  const canvas = useRef<HTMLCanvasElement>(null);
  const density = desk.density.value;
  const view = desk.view.value;
  const legible = view.zoom >= kLegible * density;
  const stage = desk.stage.value;
  const panes = desk.panes.value;
  const shown = desk.shown.value;
  useEffect(() => {
    const context = legible ? canvas.current?.getContext("2d") : null;
    if (!context) return;
    context.canvas.width = stage.width;
    context.canvas.height = stage.height;
    context.textAlign = "center";
    context.textBaseline = "middle";
    const size = Math.min(14 * density, view.zoom / 5);
    context.font = `${size}px ui-monospace, "DejaVu Sans Mono", monospace`;
    context.lineWidth = 3 * density;
    context.strokeStyle = "rgb(0 0 0 / 75%)";
    context.fillStyle = "#fff";
    context.lineJoin = "round";
    for (const { index, box, clip } of panes) {
      const picture = shown[index]?.picture;
      if (!picture) continue;
      const { image } = picture;
      context.save();
      context.beginPath();
      context.rect(clip.x, clip.y, clip.width, clip.height);
      context.clip();
      const first = imagePoint(view, box, { x: 0, y: 0 });
      const last = imagePoint(view, box, { x: box.width, y: box.height });
      for (let y = Math.max(0, Math.floor(first.y)); y < Math.min(image.height, last.y); ++y)
        for (let x = Math.max(0, Math.floor(first.x)); x < Math.min(image.width, last.x); ++x) {
          const values = valuesOf(picture, x, y);
          const middle = panePoint(view, box, { x: x + 0.5, y: y + 0.5 });
          values.forEach((value, k) => {
            const top = box.y + middle.y + (k - (values.length - 1) / 2) * 1.25 * size;
            context.strokeText(shortText(value), box.x + middle.x, top);
            context.fillText(shortText(value), box.x + middle.x, top);
          });
        }
      context.restore();
    }
  });
  return legible ? <canvas ref={canvas} class="compare-numbers" aria-hidden="true" /> : null;
}
