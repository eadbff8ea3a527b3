// Numbers as people read them.

import type { StopConditions } from "../api/types";

export const kNone = "–";

/** 0.00123 as "1.23 ms", 95 as "95 s", 4000 as "1 h 7 min". */
export function secondsText(seconds: number | null | undefined): string {
  if (seconds === null || seconds === undefined || !Number.isFinite(seconds)) return kNone;
  if (seconds === 0) return "0 s";
  if (seconds < 1e-3) return `${numberText(seconds * 1e6)} µs`;
  if (seconds < 1) return `${numberText(seconds * 1e3)} ms`;
  if (seconds < 120) return `${numberText(seconds)} s`;
  const minutes = Math.round(seconds / 60);
  if (minutes < 60) return `${minutes} min`;
  if (minutes < 48 * 60) return `${Math.floor(minutes / 60)} h ${minutes % 60} min`;
  return `${Math.round(minutes / 60 / 24)} days`;
}

const kBytes = ["B", "kB", "MB", "GB", "TB"];

export function bytesText(bytes: number | null | undefined): string {
  if (bytes === null || bytes === undefined) return kNone;
  const power = bytes < 1 ? 0 : Math.min(kBytes.length - 1, Math.floor(Math.log10(bytes) / 3));
  return `${power === 0 ? bytes : numberText(bytes / 1000 ** power)} ${kBytes[power]}`;
}

/** Three digits, without an exponent where a person would write none. */
export function numberText(value: number | null | undefined, digits = 3): string {
  if (value === null || value === undefined || Number.isNaN(value)) return kNone;
  if (value === 0) return "0";
  if (!Number.isFinite(value)) return value > 0 ? "∞" : "−∞";
  const size = Math.abs(value);
  if (size >= 1e-4 && size < 1e6) {
    const rounded = Number(value.toPrecision(digits));
    return size >= 10 ** digits ? Math.round(value).toLocaleString("en") : String(rounded);
  }
  return value.toExponential(digits - 1).replace("e+", "e").replace("-", "−");
}

const kCounts: [number, string][] = [[1e12, "T"], [1e9, "G"], [1e6, "M"], [1e3, "k"]];

/** 1234567 as "1.23 M". */
export function countText(count: number | null | undefined): string {
  if (count === null || count === undefined) return kNone;
  for (const [size, name] of kCounts) if (count >= size * 10) return `${numberText(count / size)} ${name}`;
  return numberText(count, 4);
}

export const percentText = (share: number): string => `${Math.round(100 * share)} %`;

export function stopText(stop: StopConditions): string {
  const parts: string[] = [];
  if (stop.passes) parts.push(`${stop.passes.toLocaleString("en")} passes`);
  if (stop.seconds) parts.push(secondsText(stop.seconds));
  if (stop.target) parts.push(`${stop.target.metric} ≤ ${stop.target.value}`);
  return parts.join(" or ") || kNone;
}

export const sizeText = (image: { width: number; height: number }): string => `${image.width} × ${image.height}`;

/** "14:02:11" today, "3 Nov 14:02" before. */
export function timeText(time: string | null, now = new Date()): string {
  if (!time) return kNone;
  const at = new Date(time);
  if (at.toDateString() === now.toDateString()) return at.toLocaleTimeString("en-GB");
  return `${at.getDate()} ${at.toLocaleString("en", { month: "short" })} ${at.toLocaleTimeString("en-GB", { hour: "2-digit", minute: "2-digit" })}`;
}

/** photon_mapping as "photon mapping". */
export const plainName = (name: string): string => name.replaceAll("_", " ");
