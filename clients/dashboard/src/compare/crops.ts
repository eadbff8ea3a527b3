// Parts of the images to be seen enlarged beside each other.

import { clamp, type Point, type Size } from "./view";

/** In whole pixels of the images. */
export interface Crop {
  x: number;
  y: number;
  width: number;
  height: number;
}

export const kMaxCrops = 6;
export const kMaxCropSide = 1024;
/** What a crop has that is put somewhere rather than drawn. */
export const kNewCropSide = 48;

/** "x,y,width,height" each, a semicolon between two. */
export const cropsText = (crops: Crop[]): string => crops.map((crop) => `${crop.x},${crop.y},${crop.width},${crop.height}`).join(";");

export function cropsOfText(text: string): { crops: Crop[]; faults: string[] } {
  const crops: Crop[] = [];
  const faults: string[] = [];
  for (const part of text.split(";").filter(Boolean)) {
    const values = part.split(",").map((value) => (value.trim() === "" ? NaN : Number(value)));
    const [x = NaN, y = NaN, width = NaN, height = NaN] = values;
    if (values.length === 4 && values.every(Number.isInteger) && width >= 1 && height >= 1 && width <= kMaxCropSide && height <= kMaxCropSide)
      crops.push({ x, y, width, height });
    else faults.push(`crops: “${part}” is not x,y,width,height in whole pixels, sides from 1 to ${kMaxCropSide}`);
  }
  if (crops.length > kMaxCrops) faults.push(`crops: ${crops.length} are named; the first ${kMaxCrops} are shown`);
  return { crops: crops.slice(0, kMaxCrops), faults };
}

/** The pixels between two corners that were drawn, both in it; null where none of the image is. */
export function cropBetween(from: Point, to: Point, image: Size): Crop | null {
  const along = (a: number, b: number, side: number): [number, number] | null => {
    const first = Math.max(0, Math.floor(Math.min(a, b)));
    const last = Math.min(side - 1, Math.floor(Math.max(a, b)));
    return first <= last ? [first, Math.min(kMaxCropSide, last - first + 1)] : null;
  };
  const across = along(from.x, to.x, image.width);
  const down = along(from.y, to.y, image.height);
  return across && down && { x: across[0], y: down[0], width: across[1], height: down[1] };
}

/** A crop of the usual size about a place, inside the image. */
export function cropAbout(at: Point, image: Size): Crop {
  const width = Math.min(kNewCropSide, image.width);
  const height = Math.min(kNewCropSide, image.height);
  return {
    x: clamp(Math.floor(at.x - width / 2), 0, image.width - width),
    y: clamp(Math.floor(at.y - height / 2), 0, image.height - height),
    width,
    height,
  };
}

/** Moved and sized to lie inside the image. */
export function cropWithin(crop: Crop, image: Size): Crop {
  const whole = (value: number) => (Number.isFinite(value) ? Math.round(value) : 0);
  const width = clamp(whole(crop.width), 1, Math.min(kMaxCropSide, image.width));
  const height = clamp(whole(crop.height), 1, Math.min(kMaxCropSide, image.height));
  return { x: clamp(whole(crop.x), 0, image.width - width), y: clamp(whole(crop.y), 0, image.height - height), width, height };
}
