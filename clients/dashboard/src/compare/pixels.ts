// An image's values as the daemon sends them, and what is known of them as a whole.

import { askPatiently, withQuery } from "../api/client";
import { halfTable } from "./half";

export type Precision = "half" | "float";

export interface PixelImage {
  width: number;
  height: number;
  /** 1 or 3, interleaved. */
  channels: number;
  /** Row 0 at the top; halves by their bits. */
  data: Uint16Array | Float32Array;
  /** Finite values that half precision has made infinite. */
  overflowed: number;
  statistics: PixelStatistics;
}

export interface PixelStatistics {
  /** Of the finite values of all channels; null where there are none. */
  mean: number | null;
  low: number | null;
  high: number | null;
  /** Pixels that hold one. */
  nans: number;
  infinities: number;
  /** The first of the pixels that hold an infinite value, by their numbers in the order of rows. */
  infinite: { index: number; negative: boolean }[];
}

const kListed = 100_000;

/** Reads a value by its index in `data`. */
export function reader(data: Uint16Array | Float32Array): (index: number) => number {
  if (data instanceof Float32Array) return (index) => data[index]!;
  const half = halfTable();
  return (index) => half[data[index]!]!;
}

/** The pixel's channels; null outside the image. */
export function pixelAt(image: PixelImage, x: number, y: number): number[] | null {
  if (x < 0 || y < 0 || x >= image.width || y >= image.height) return null;
  const read = reader(image.data);
  const first = (y * image.width + x) * image.channels;
  return Array.from({ length: image.channels }, (_, channel) => read(first + channel));
}

export function statisticsOf(data: Uint16Array | Float32Array, channels: number): PixelStatistics {
  const values = data instanceof Float32Array ? null : halfTable();
  let sum = 0;
  let count = 0;
  let low = Infinity;
  let high = -Infinity;
  let nans = 0;
  let infinities = 0;
  const infinite: PixelStatistics["infinite"] = [];
  for (let first = 0; first < data.length; first += channels) {
    let hasNan = false;
    let infinity = 0;
    for (let i = first; i < first + channels; ++i) {
      const value = values ? values[data[i]!]! : data[i]!;
      if (Number.isFinite(value)) {
        sum += value;
        ++count;
        if (value < low) low = value;
        if (value > high) high = value;
      } else if (value !== value) hasNan = true;
      else if (infinity <= 0) infinity = value;
    }
    if (hasNan) ++nans;
    if (infinity === 0) continue;
    ++infinities;
    if (!hasNan && infinite.length < kListed) infinite.push({ index: first / channels, negative: infinity < 0 });
  }
  const found = { nans, infinities, infinite };
  return count ? { mean: sum / count, low, high, ...found } : { mean: null, low: null, high: null, ...found };
}

export function pixelImage(width: number, height: number, channels: number, data: Uint16Array | Float32Array, overflowed = 0): PixelImage {
  if (data.length !== width * height * channels)
    throw new Error(`the daemon sent ${data.length} values for ${width} × ${height} pixels of ${channels} channels`);
  return { width, height, channels, data, overflowed, statistics: statisticsOf(data, channels) };
}

const pathOf = (source: string): string =>
  source.startsWith("job:") ? `/v1/jobs/${encodeURIComponent(source.slice(4))}` : `/v1/images/${encodeURIComponent(source.slice(6))}`;

export { pathOf as pathOfSource };

export interface Fetched {
  image: PixelImage;
  /** The mean that the daemon says with a FLIP map. */
  flipMean: number | null;
}

async function fetchPixels(path: string, precision: Precision, signal: AbortSignal): Promise<Fetched | null> {
  const answer = await askPatiently(path, signal);
  if (answer.status === 202) return null;
  const number = (name: string) => Number(answer.headers.get(name) ?? NaN);
  const bytes = await answer.arrayBuffer();
  const data = precision === "half" ? new Uint16Array(bytes) : new Float32Array(bytes);
  const mean = number("X-Flip-Mean");
  return {
    image: pixelImage(number("X-Image-Width"), number("X-Image-Height"), number("X-Image-Channels"), data, number("X-Image-Overflowed") || 0),
    flipMean: Number.isNaN(mean) ? null : mean,
  };
}

/** A layer of a job or an image; null while there is nothing rendered yet. */
export const fetchLayer = (source: string, layer: string, precision: Precision, signal: AbortSignal): Promise<Fetched | null> =>
  fetchPixels(withQuery(`${pathOf(source)}/pixels`, { layer, precision }), precision, signal);

/** The FLIP map of one against the other, values in [0, 1]; null while one of them has nothing yet. */
export const fetchFlip = (image: string, reference: string, layer: string, range: "ldr" | "hdr", signal: AbortSignal): Promise<Fetched | null> =>
  fetchPixels(withQuery("/v1/flip", { image, reference, layer, range, precision: "half" }), "half", signal);
