// Errors as far as they are known: what the noise of a reference leaves open, and what is no more than an upper bound.

import type { ErrorNow, NoiseInterval } from "../api/types";
import { kNone, numberText, plainName } from "./format";

const endsText = ([least, greatest]: NoiseInterval): string => `${numberText(least)} to ${numberText(greatest)}`;

/** What is drawn of an error on a logarithmic axis. */
export interface DrawnError {
  at: number;
  /** The error is not told apart from 0: it is below, as far as is known. */
  isBound: boolean;
  /** 0 or less where the axis has no end for it. */
  least: number;
  greatest: number;
}

/**
 * Where the value is 0 or less: the upper end of its interval; by luck that is 0 or less too, and then half of the width
 * says what is known. Null where a logarithmic axis has no place at all.
 */
export function drawnError(value: number | null | undefined, interval: NoiseInterval | null | undefined): DrawnError | null {
  if (interval && !((value ?? 0) > 0) && interval[1] > interval[0]) {
    const at = interval[1] > 0 ? interval[1] : (interval[1] - interval[0]) / 2;
    return { at, isBound: true, least: interval[0], greatest: at };
  }
  if (!(value! > 0) || !Number.isFinite(value)) return null;
  return { at: value!, isBound: false, least: interval?.[0] ?? value!, greatest: interval?.[1] ?? value! };
}

/** "0.0012 (0.0008 to 0.0016)"; "below 0.004 (not told apart from 0)" where the estimate is 0 or less. */
export function errorWithInterval(value: number | null | undefined, interval: NoiseInterval | null | undefined): string {
  const drawn = drawnError(value, interval);
  if (drawn?.isBound) return `below ${numberText(drawn.at)} (not told apart from 0)`;
  return interval && drawn ? `${numberText(value)} (${endsText(interval)})` : numberText(value);
}

/** The same where there is little room: "0.0012", "below 0.004". */
export function shortError(value: number | null | undefined, interval: NoiseInterval | null | undefined): string {
  const drawn = drawnError(value, interval);
  return drawn?.isBound ? `below ${numberText(drawn.at)}` : numberText(value);
}

/** "0.0012 relative mse", as lists have it; empty where there is none. */
export function errorNowText(error: ErrorNow | null | undefined): string {
  const text = error ? shortError(error.value, error.interval) : kNone;
  return text === kNone ? "" : `${text} ${plainName(error!.metric)}`;
}
