// All of what the room shows but the pixels themselves, and how an address says it: a link brings the same view back.

import { clamp, kGreatestZoom, kLeastZoom, type Point } from "./view";
import type { Precision } from "./pixels";
import type { Crop } from "./crops";
import { cropsOfText, cropsText } from "./crops";

export const kModes = ["single", "wipe", "side", "grid"] as const;
export const kCurves = ["srgb", "filmic", "aces", "agx", "neutral", "linear"] as const;
/** Of values and of light in false colours; "usual": light as light, values by the daemon's own map. */
export const kFalseColours = ["usual", "viridis", "magma", "inferno", "plasma", "turbo", "grey"] as const;
export const kChannels = ["rgb", "r", "g", "b", "luminance"] as const;
export const kErrors = ["none", "signed", "relative", "flip_hdr", "flip_ldr"] as const;
export type Mode = (typeof kModes)[number];
export type Curve = (typeof kCurves)[number];
export type FalseColours = (typeof kFalseColours)[number];
export type Channel = (typeof kChannels)[number];
export type ErrorKind = (typeof kErrors)[number];

export const kMaxImages = 9;
export const kMaxCropZoom = 16;

export interface Look {
  /** "job:J17" or "image:ID", each once. */
  images: string[];
  /** One of the images; null: the one that the images' jobs say, or the first. */
  reference: string | null;
  layer: string;
  mode: Mode;
  /** The image that is shown, or the left one of two. */
  shown: number;
  /** The right one of two; null: the reference, or where that is shown the next. */
  beside: number | null;
  /** Null: the whole image. */
  zoom: number | null;
  centre: Point | null;
  /** Stops. */
  exposure: number;
  curve: Curve;
  colours: FalseColours;
  channel: Channel;
  error: ErrorKind;
  /** The signed error at the ends of its scale; null: from the reference's mean. */
  span: number | null;
  /** Ends of the scale of layers that are no light; null: from the images. */
  range: [number, number] | null;
  /** Share of the pane that the left or upper image has. */
  wipe: number;
  wipeAcross: boolean;
  crops: Crop[];
  cropZoom: number;
  /** The pixel that is read where the pointer is not on the image. */
  pixel: Point | null;
  precision: Precision;
}

export const kStart: Look = {
  images: [],
  reference: null,
  layer: "beauty",
  mode: "single",
  shown: 0,
  beside: null,
  zoom: null,
  centre: null,
  exposure: 0,
  curve: "srgb",
  colours: "usual",
  channel: "rgb",
  error: "none",
  span: null,
  range: null,
  wipe: 0.5,
  wipeAcross: false,
  crops: [],
  cropZoom: 4,
  pixel: null,
  precision: "half",
};

/** A source as it is typed: "J17" and "17" are jobs. Null where it is none. */
export function sourceOfText(text: string): string | null {
  const typed = text.trim();
  if (/^(job|image):[\w.-]+$/.test(typed)) return typed;
  if (/^J\d+$/i.test(typed)) return `job:${typed.toUpperCase()}`;
  if (/^\d+$/.test(typed)) return `job:J${typed}`;
  if (/^[0-9a-zA-Z_-]{8,}$/.test(typed)) return `image:${typed}`;
  return null;
}

const short = (value: number): string => String(Number(value.toPrecision(7)));

/** The members of an address's query; null where it is as at the start. */
export function queryOf(look: Look): Record<string, string | null> {
  const point = (at: Point | null) => at && `${short(at.x)},${short(at.y)}`;
  const unlessStart = <Name extends keyof Look>(name: Name, text: (value: NonNullable<Look[Name]>) => string) => {
    const value = look[name];
    return value === null || value === kStart[name] ? null : text(value as NonNullable<Look[Name]>);
  };
  return {
    images: look.images.join(",") || null,
    reference: look.reference,
    layer: unlessStart("layer", String),
    mode: unlessStart("mode", String),
    show: unlessStart("shown", (index) => String(index + 1)),
    beside: unlessStart("beside", (index) => String(index + 1)),
    zoom: unlessStart("zoom", short),
    at: point(look.centre),
    exposure: unlessStart("exposure", short),
    curve: unlessStart("curve", String),
    colours: unlessStart("colours", String),
    channel: unlessStart("channel", String),
    error: unlessStart("error", String),
    span: unlessStart("span", short),
    range: look.range && look.range.map(short).join(","),
    wipe: unlessStart("wipe", short),
    split: look.wipeAcross ? "across" : null,
    crops: cropsText(look.crops) || null,
    cropzoom: unlessStart("cropZoom", String),
    pixel: point(look.pixel),
    precision: unlessStart("precision", String),
  };
}

/** What a query says, and every fault of it; what is faulty is as at the start. */
export function lookOf(query: Record<string, string | undefined>): { look: Look; faults: string[] } {
  const look: Look = { ...kStart };
  const faults: string[] = [];

  function numbers(name: string, count: number, low = -Infinity, high = Infinity): number[] | null {
    const text = query[name];
    if (!text) return null;
    const values = text.split(",").map((part) => (part.trim() === "" ? NaN : Number(part)));
    if (values.length === count && values.every((value) => Number.isFinite(value) && value >= low && value <= high)) return values;
    const bounds = low === -Infinity ? "" : high === Infinity ? ` of at least ${low}` : ` from ${short(low)} to ${high}`;
    faults.push(`${name}=${text}: must be ${count === 1 ? "a number" : `${count} numbers`}${bounds}`);
    return null;
  }
  const number = (name: string, low?: number, high?: number) => numbers(name, 1, low, high)?.[0] ?? null;
  const point = (name: string): Point | null => {
    const values = numbers(name, 2);
    return values && { x: values[0]!, y: values[1]! };
  };
  function word<Word extends string>(name: string, words: readonly Word[], otherwise: Word): Word {
    const text = query[name];
    if (!text) return otherwise;
    if ((words as readonly string[]).includes(text)) return text as Word;
    faults.push(`${name}=${text}: must be one of ${words.join(", ")}`);
    return otherwise;
  }

  for (const part of (query.images ?? "").split(",").filter(Boolean)) {
    const source = sourceOfText(part);
    if (!source) faults.push(`images: “${part}” is neither job:ID nor image:ID`);
    else if (!look.images.includes(source)) look.images = [...look.images, source];
  }
  if (look.images.length > kMaxImages) {
    faults.push(`images: ${look.images.length} are named; the first ${kMaxImages} are shown`);
    look.images = look.images.slice(0, kMaxImages);
  }
  const index = (name: string): number | null => {
    const value = number(name, 1, kMaxImages);
    if (value === null || look.images.length === 0) return null;
    if (Number.isInteger(value) && value <= look.images.length) return value - 1;
    faults.push(`${name}=${value}: there are images 1 to ${look.images.length}`);
    return null;
  };
  const reference = query.reference ? sourceOfText(query.reference) : null;
  if (reference && look.images.includes(reference)) look.reference = reference;
  else if (query.reference) faults.push(`reference=${query.reference}: is none of the images`);
  look.layer = query.layer || kStart.layer;
  look.mode = word("mode", kModes, kStart.mode);
  look.shown = index("show") ?? 0;
  look.beside = index("beside");
  look.zoom = number("zoom", kLeastZoom, kGreatestZoom);
  look.centre = point("at");
  look.exposure = number("exposure", -30, 30) ?? 0;
  look.curve = word("curve", kCurves, kStart.curve);
  look.colours = word("colours", kFalseColours, kStart.colours);
  look.channel = word("channel", kChannels, kStart.channel);
  look.error = word("error", kErrors, kStart.error);
  look.span = number("span", 1e-12);
  const range = numbers("range", 2);
  if (range && range[0]! < range[1]!) look.range = [range[0]!, range[1]!];
  else if (range) faults.push(`range=${query.range}: the first must be less than the second`);
  look.wipe = number("wipe", 0, 1) ?? kStart.wipe;
  look.wipeAcross = word("split", ["across", "down"], "down") === "across";
  const crops = cropsOfText(query.crops ?? "");
  look.crops = crops.crops;
  faults.push(...crops.faults);
  look.cropZoom = clamp(Math.round(number("cropzoom", 1, kMaxCropZoom) ?? kStart.cropZoom), 1, kMaxCropZoom);
  const pixel = point("pixel");
  look.pixel = pixel && { x: Math.floor(pixel.x), y: Math.floor(pixel.y) };
  look.precision = word("precision", ["half", "float"], "half");
  return { look, faults };
}

/** The image beside the shown one. */
export function besideOf(look: Look, reference: number): number {
  if (look.beside !== null && look.beside < look.images.length) return look.beside;
  return reference !== look.shown ? reference : (look.shown + 1) % Math.max(1, look.images.length);
}

/** Without one of its images: what pointed past it points at what it did. */
export function withoutImage(look: Look, index: number): Look {
  const images = look.images.filter((_, i) => i !== index);
  const moved = (at: number) => clamp(at > index ? at - 1 : at, 0, Math.max(0, images.length - 1));
  return {
    ...look,
    images,
    reference: look.reference === look.images[index] ? null : look.reference,
    shown: moved(look.shown),
    beside: look.beside === null || look.beside === index ? null : moved(look.beside),
  };
}

/** With more images at the end, each once, as far as there is room. */
export const withImages = (look: Look, sources: string[]): Look => ({
  ...look,
  images: [...new Set([...look.images, ...sources])].slice(0, kMaxImages),
});
