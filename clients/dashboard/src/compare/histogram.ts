// How often which brightness is in an image: light by stops of its luminance, other values evenly over their scale.

import { luminanceOf } from "./paint";
import { reader, type PixelImage } from "./pixels";

export interface Histogram {
  /** Share of the finite pixels in each bin; those beyond the ends are in the first and the last. */
  shares: number[];
  /** Value at the lower end of the first bin and the upper end of the last: log2 of light, else the value itself. */
  low: number;
  high: number;
  /** Of all pixels, those that are black or less, which have no stops. */
  black: number;
  /** Of all pixels, those above `white`. */
  above: number;
}

/** Stops about middle grey that are shown. */
const kStops: [number, number] = [-14, 10];
const kBins = 96;

/** Of light: `white` is the luminance that is shown white. */
export function lightHistogram(image: PixelImage, white: number): Histogram {
  return counted(image, kStops, white, (value) => (value > 0 ? Math.log2(value) : null));
}

export function valueHistogram(image: PixelImage, low: number, high: number): Histogram {
  return counted(image, [low, high], high, (value) => value);
}

function counted({ data, channels }: PixelImage, [low, high]: [number, number], white: number, placeOf: (value: number) => number | null): Histogram {
  const read = reader(data);
  const counts = new Array<number>(kBins).fill(0);
  let finite = 0;
  let black = 0;
  let above = 0;
  for (let first = 0; first < data.length; first += channels) {
    const value = channels === 1 ? read(first) : luminanceOf([read(first), read(first + 1), read(first + 2)]);
    if (!Number.isFinite(value)) continue;
    ++finite;
    if (value > white) ++above;
    const place = placeOf(value);
    if (place === null) {
      ++black;
      continue;
    }
    ++counts[Math.min(kBins - 1, Math.max(0, Math.floor(((place - low) / (high - low)) * kBins)))]!;
  }
  const share = (count: number) => (finite ? count / finite : 0);
  return { shares: counts.map(share), low, high, black: share(black), above: share(above) };
}
