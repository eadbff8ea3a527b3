// How values become colours: which quantity of an image is shown, on which scale, by which colours. The shader
// (shaders.ts), the colour bar and the table of values go by it.

import { layerNamed } from "../api/vocabulary";
import { numberText } from "../ui/format";
import { srgbEncode, type MapName } from "./colour_maps";
import type { Channel, Curve, ErrorKind, Look } from "./look";
import { acesFitted, agx, pbrNeutral, type Triple } from "./view_transforms";

export type LayerKind = "light" | "directions" | "positions" | "splats" | "value";

/** What a layer holds, which the display goes by. */
export function layerKind(name: string, channels: number): LayerKind {
  const layer = layerNamed(name);
  if (channels === 1) return layer?.preview === "heat_map" ? "splats" : layer?.measured ? "light" : "value";
  if (layer?.channels === "XYZ") return layer.unit ? "positions" : "directions";
  return "light";
}

export const channelNames = (kind: LayerKind, channels: number): string[] =>
  channels === 1 ? ["value"] : kind === "directions" || kind === "positions" ? ["x", "y", "z"] : ["R", "G", "B"];

export interface Paint {
  quantity: "pixel" | "signed" | "relative";
  /** Of light that is shown by all three channels, each; otherwise what one number is made of. */
  channel: Channel;
  colours: "tone" | "straight" | "map" | "log";
  map: MapName;
  curve: Curve;
  /** What light is multiplied by before its curve. */
  scale: number;
  /** Ends of the scale of the others. */
  low: number;
  high: number;
  /** 0.01 m^2, m being the mean of the reference: what keeps relative errors of dark pixels finite. */
  floor: number;
}

/** Ends of the daemon's scale for relative errors (server/worker/helper_errors.h). */
export const kRelativeLow = 1e-3;
export const kRelativeHigh = 10;
const kMostSplats = 600;
/** What exposure is about: the daemon's (renderer/film/tone_curve.h). */
export const kMiddleGrey = 0.18;
/** Ends of the scale of light in false colours, from middle grey. */
const kFalseStops = [-6, 6];

/** 1, 2 or 5 times a power of ten, the nearest. */
export function roundScale(value: number): number {
  if (!(value > 0) || !Number.isFinite(value)) return 1;
  const power = 10 ** Math.floor(Math.log10(value));
  const near = [1, 2, 5, 10].reduce((best, step) => (Math.abs(Math.log(step * power / value)) < Math.abs(Math.log(best * power / value)) ? step : best));
  return Number((near * power).toPrecision(1));
}

export interface Ground {
  layer: string;
  channels: number;
  /** The mean of the reference's values; null without reference. */
  referenceMean: number | null;
  /** Ends of the values of all images. */
  low: number | null;
  high: number | null;
}

/** The signed error at the ends of its scale. */
export const spanOf = (look: Look, ground: Ground): number => look.span ?? roundScale(Math.abs(ground.referenceMean ?? 1));

/** Ends of the scale of values that are no light. */
export function rangeOf(look: Look, ground: Ground): [number, number] {
  if (look.range) return look.range;
  const kind = layerKind(ground.layer, ground.channels);
  if (kind === "directions") return [-1, 1];
  if (kind === "splats") return [0, kMostSplats];
  const low = ground.low ?? 0;
  const high = ground.high ?? 1;
  const from = low > 0 && low < high / 4 ? 0 : low;
  return high > from ? [from, high] : [from, from + 1];
}

/** Whether the layer's brightness is a matter of exposure and curve. */
export const isLight = (layer: string, channels: number): boolean => layerKind(layer, channels) === "light";

/** What one number says of three: light by its luminance, anything else by its first component. */
const oneChannel = (channel: Channel, kind: LayerKind): Channel =>
  kind === "light" ? (channel === "rgb" ? "luminance" : channel) : channel === "rgb" || channel === "luminance" ? "r" : channel;

export function paintOf(look: Look, ground: Ground, error: ErrorKind): Paint {
  const kind = layerKind(ground.layer, ground.channels);
  const [low, high] = rangeOf(look, ground);
  const paint: Paint = {
    quantity: "pixel",
    channel: ground.channels === 1 ? "r" : look.channel,
    colours: "tone",
    map: look.colours === "usual" ? "magnitude" : look.colours,
    curve: look.curve,
    scale: 2 ** look.exposure,
    low,
    high,
    floor: 0.01 * (ground.referenceMean ?? 0) ** 2,
  };
  if (error === "signed") {
    const span = spanOf(look, ground);
    return { ...paint, quantity: "signed", channel: oneChannel(paint.channel, kind), colours: "map", map: "signed", low: -span, high: span };
  }
  if (error === "relative") return { ...paint, quantity: "relative", colours: "log", low: kRelativeLow, high: kRelativeHigh };
  if (error !== "none") return { ...paint, channel: "r", colours: "map", low: 0, high: 1 };
  if (kind === "light" && look.colours === "usual") return paint;
  if (kind === "light") {
    const [from, to] = kFalseStops.map((stops) => (kMiddleGrey * 2 ** stops) / paint.scale) as [number, number];
    return { ...paint, channel: oneChannel(paint.channel, kind), colours: "log", low: from, high: to };
  }
  if (kind === "splats") return { ...paint, colours: "map", map: "heat" };
  if (ground.channels === 3 && (look.channel === "rgb" || look.channel === "luminance")) return { ...paint, channel: "rgb", colours: "straight" };
  return { ...paint, colours: "map" };
}

/** Rolls highlights off; the daemon's (renderer/film/tone_curve.cpp): Narkowicz' fit to ACES without its own exposure. */
export function filmic(light: number): number {
  const x = 0.6 * light;
  return x > 1e4 ? 1 : (x * (2.51 * x + 0.03)) / (x * (2.43 * x + 0.59) + 0.14);
}
/** The light that the filmic curve makes white. */
export const kFilmicWhite = (0.56 + Math.sqrt(0.56 ** 2 + 4 * 0.08 * 0.14)) / (2 * 0.08) / 0.6;

const kTransforms: Partial<Record<Curve, (light: Triple) => Triple>> = { aces: acesFitted, agx, neutral: pbrNeutral };
/** Those that give what the display is sent; the others give linear light. */
const kEncoded: Curve[] = ["linear", "agx"];

/** What a display is sent for light, 0 to 1 a channel. */
export function displayed(light: Triple, curve: Curve): Triple {
  const lit = light.map((x) => Math.min(1e6, x > 0 ? x : 0)) as Triple;
  const shown = kTransforms[curve]?.(lit) ?? (curve === "filmic" ? (lit.map(filmic) as Triple) : lit);
  return shown.map((x) => {
    const bounded = Math.min(1, Math.max(0, x));
    return kEncoded.includes(curve) ? bounded : srgbEncode(bounded);
  }) as Triple;
}

/** The same for grey light. */
export const toned = (light: number, curve: Curve): number => displayed([light, light, light], curve)[1];

const whites = new Map<Curve, number>();
/** The least grey light that is shown white, to what 8 bits tell. */
export function whiteLight(curve: Curve): number {
  if (curve === "srgb" || curve === "linear") return 1;
  if (curve === "filmic") return kFilmicWhite;
  let white = whites.get(curve);
  if (white === undefined) {
    let [dark, bright] = [-10, 16]; // stops
    for (let step = 0; step < 40; ++step) {
      const middle = (dark + bright) / 2;
      if (Math.round(255 * toned(2 ** middle, curve)) === 255) bright = middle;
      else dark = middle;
    }
    whites.set(curve, (white = 2 ** bright));
  }
  return white;
}

export const luminanceOf = (pixel: number[]): number =>
  pixel.length === 1 ? pixel[0]! : 0.2126 * pixel[0]! + 0.7152 * pixel[1]! + 0.0722 * pixel[2]!;

function picked(pixel: number[], channel: Channel): number {
  if (pixel.length === 1) return pixel[0]!;
  return channel === "luminance" ? luminanceOf(pixel) : pixel["rgb".indexOf(channel)]!;
}

/** Image less reference, of the channel; of all three, of their luminance. */
export const signedError = (pixel: number[], reference: number[], channel: Channel): number => {
  const one = channel === "rgb" ? "luminance" : channel;
  return picked(pixel, one) - picked(reference, one);
};

/** Root of the mean over channels of (x - r)^2 / (r^2 + floor); NaN where a value is not finite or nothing is to divide by. */
export function relativeError(pixel: number[], reference: number[], channel: Channel, floor: number): number {
  const one = (x: number, r: number) => (Number.isFinite(x) && Number.isFinite(r) ? (x - r) ** 2 / (r ** 2 + floor) : NaN);
  if (channel !== "rgb" || pixel.length === 1) return Math.sqrt(one(picked(pixel, channel), picked(reference, channel)));
  return Math.sqrt(pixel.reduce((sum, x, k) => sum + one(x, reference[k]!), 0) / pixel.length);
}

/** A value's place on the scale, 0 to 1. */
export function placeOf(paint: Paint, value: number): number {
  const place = paint.colours === "log" ? Math.log(value / paint.low) / Math.log(paint.high / paint.low) : (value - paint.low) / (paint.high - paint.low);
  return Math.min(1, Math.max(0, place));
}

export interface Tick {
  place: number;
  text: string;
}

/** The numbers beside the colour bar. */
export function ticksOf(paint: Paint): Tick[] {
  if (paint.colours === "log") {
    const decades = Math.round(Math.log10(paint.high / paint.low));
    if (paint.quantity === "pixel")
      return [0, 0.25, 0.5, 0.75, 1].map((place) => ({ place, text: numberText(paint.low * (paint.high / paint.low) ** place) }));
    return Array.from({ length: decades + 1 }, (_, i) => ({ place: i / decades, text: numberText(Number((paint.low * 10 ** i).toPrecision(6))) }));
  }
  const [low, high] = paint.colours === "tone" ? [0, whiteOf(paint)] : [paint.low, paint.high];
  return [0, 0.25, 0.5, 0.75, 1].map((place) => {
    const text = numberText(low + place * (high - low)).replace("-", "−");
    return { place, text: paint.quantity === "signed" && place > 0.5 ? `+${text}` : text };
  });
}

/** The light that is shown white. */
export const whiteOf = (paint: Paint): number => whiteLight(paint.curve) / paint.scale;

/** What the numbers are of. */
export function scaleTitle(paint: Paint, error: ErrorKind, layer: string, channels: number): string {
  const name = channelNames(layerKind(layer, channels), channels)["rgb".indexOf(paint.channel)];
  const of = paint.channel === "luminance" ? ", luminance" : paint.channel === "rgb" || channels === 1 ? "" : `, ${name}`;
  switch (error) {
    case "signed": return `Image − reference${of}`;
    case "relative": return `Relative error${of}`;
    case "flip_hdr": return "HDR-FLIP";
    case "flip_ldr": return "LDR-FLIP";
    case "none": break;
  }
  const kind = layerKind(layer, channels);
  if (kind === "light") return `Radiance${of}`;
  if (kind === "splats") return "Splats over a pixel";
  if (kind === "directions") return "Component of the direction";
  const unit = layerNamed(layer)?.unit;
  return layer.replaceAll("_", " ") + (unit ? ` [${unit}]` : "");
}
