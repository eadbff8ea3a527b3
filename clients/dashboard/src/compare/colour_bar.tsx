// The scale of the colours, with its numbers: always there, and the same for all images.

import { useEffect, useRef } from "preact/hooks";

import { colourAt, colourMap } from "./colour_maps";
import type { Desk } from "./desk";
import { scaleTitle, ticksOf, toned, whiteOf, type Paint } from "./paint";

const kSteps = 512;

/** The colour at a place of the bar: red, green and blue, 0 to 255. */
export function barColour(paint: Paint, place: number): [number, number, number] {
  if (paint.colours === "map" || paint.colours === "log") return colourAt(colourMap(paint.map), place);
  const grey = Math.round(255 * (paint.colours === "tone" ? toned(place * whiteOf(paint) * paint.scale, paint.curve) : place));
  return [grey, grey, grey];
}

export function paintBar(context: CanvasRenderingContext2D, paint: Paint, box: { x: number; y: number; width: number; height: number }): void {
  for (let i = 0; i < box.width; ++i) {
    const [red, green, blue] = barColour(paint, i / (box.width - 1));
    context.fillStyle = `rgb(${red} ${green} ${blue})`;
    context.fillRect(box.x + i, box.y, 1, box.height);
  }
}

export const barPaint = (desk: Desk): Paint => (desk.part("images").value.length > 1 ? desk.paints.value.error : desk.paints.value.image);
export const barTitle = (desk: Desk): string =>
  scaleTitle(barPaint(desk), desk.part("images").value.length > 1 ? desk.part("error").value : "none", desk.part("layer").value, desk.ground.value.channels);

export function ColourBar({ desk }: { desk: Desk }) {
  const canvas = useRef<HTMLCanvasElement>(null);
  const paint = barPaint(desk);
  useEffect(() => paintBar(canvas.current!.getContext("2d")!, paint, { x: 0, y: 0, width: kSteps, height: 1 }), [paint]);
  const title = barTitle(desk);
  const ticks = ticksOf(paint);
  return (
    <figure class="compare-bar" aria-label={`Colours: ${title}, from ${ticks[0]!.text} to ${ticks.at(-1)!.text}`}>
      <figcaption>{title}</figcaption>
      <div>
        <canvas ref={canvas} width={kSteps} height={1} aria-hidden="true" />
        <div class="compare-ticks">
          {ticks.map(({ place, text }) => (
            <span key={place} style={{ left: `${100 * place}%` }}>
              {text}
            </span>
          ))}
        </div>
      </div>
      <p class="compare-legend">
        <span class="nan" aria-hidden="true" /> NaN <span class="infinite" aria-hidden="true" /> ∞
      </p>
    </figure>
  );
}
