// The histogram of the image that is shown, with the ends of what its display shows.

import { useMemo } from "preact/hooks";

import { numberText, percentText } from "../ui/format";
import type { Desk } from "./desk";
import { lightHistogram, valueHistogram } from "./histogram";
import { isLight, kMiddleGrey, rangeOf, whiteOf } from "./paint";

const kWidth = 320;
const kHeight = 72;

export function HistogramPanel({ desk }: { desk: Desk }) {
  const shown = desk.part("shown").value;
  const image = desk.pixels(shown);
  const ground = desk.ground.value;
  const look = desk.look.value;
  const paint = desk.paints.value.image;
  const light = isLight(ground.layer, ground.channels);
  const [from, to] = rangeOf(look, ground);
  const white = paint.colours === "log" ? paint.high : whiteOf(paint);
  const histogram = useMemo(() => image && (light ? lightHistogram(image, white) : valueHistogram(image, from, to)), [image, light, white, from, to]);
  if (!histogram) return null;
  const { shares, low, high, black, above } = histogram;
  // By the root, so that what is rare is seen beside what is not.
  const most = Math.sqrt(Math.max(...shares, 1e-9));
  const step = kWidth / shares.length;
  const path = shares.map((share, bin) => `M${(bin * step).toFixed(2)} ${kHeight}v${(-kHeight * Math.sqrt(share) / most).toFixed(2)}h${step.toFixed(2)}V${kHeight}z`).join("");
  const place = (stops: number) => ((stops - low) / (high - low)) * kWidth;
  const ends = light ? { grey: place(Math.log2(kMiddleGrey / paint.scale)), white: place(Math.log2(white)) } : null;
  const said = light
    ? `${percentText(above)} above white, ${percentText(black)} black`
    : `${percentText(shares[0]!)} in the lowest part, ${percentText(shares.at(-1)!)} in the highest`;
  return (
    <section class="panel" aria-labelledby="compare-histogram">
      <h2 id="compare-histogram">
        Histogram <span class="hint">image {shown + 1}, {light ? "luminance by stops" : ground.layer.replaceAll("_", " ")}</span>
      </h2>
      <svg class="compare-histogram" viewBox={`0 0 ${kWidth} ${kHeight}`} preserveAspectRatio="none" role="img" aria-label={`Histogram: ${said}`}>
        <path d={path} />
        {ends && <line class="grey" x1={ends.grey} x2={ends.grey} y1={0} y2={kHeight} />}
        {ends && <line class="white" x1={ends.white} x2={ends.white} y1={0} y2={kHeight} />}
      </svg>
      <p class="small muted compare-histogram-ends">
        <span>{light ? numberText(2 ** low) : numberText(low)}</span>
        <span>{said}</span>
        <span>{light ? numberText(2 ** high) : numberText(high)}</span>
      </p>
      {ends && <p class="hint compare-hint">Dashed: what exposure makes middle grey; solid: what is shown white.</p>}
    </section>
  );
}
