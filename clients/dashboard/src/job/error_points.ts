// What the error chart of a job draws of its curve, on logarithmic axes.

import type { CurvePoint } from "../api/types";
import { drawnError, type DrawnError } from "../ui/error_interval";

export interface ErrorPoints {
  x: number[];
  /** By metric as asked for, one for each x; null where nothing was measured. */
  drawn: (DrawnError | null)[][];
  /** How many measured values have no place on a logarithmic axis: they are 0 or below, and nothing says what they may be. */
  leftOut: number;
}

export const drawnAt = (point: CurvePoint, metric: string): DrawnError | null => drawnError(point.metrics[metric], point.intervals?.[metric]);

export function errorPoints(curve: CurvePoint[], metrics: string[], against: "seconds" | "passes"): ErrorPoints {
  const there = curve.filter((point) => point[against] > 0);
  const points = there.filter((point) => metrics.some((metric) => drawnAt(point, metric)));
  const isMeasured = (point: CurvePoint, metric: string) => Number.isFinite(point.metrics[metric]) || !!point.intervals?.[metric];
  return {
    x: points.map((point) => point[against]),
    drawn: metrics.map((metric) => points.map((point) => drawnAt(point, metric))),
    leftOut: there.reduce((sum, point) => sum + metrics.filter((metric) => isMeasured(point, metric) && !drawnAt(point, metric)).length, 0),
  };
}

/** A curve goes through values, ends before what is only bounded, and passes over where nothing was measured. */
export const lineOf = (drawn: (DrawnError | null)[]): (number | null | undefined)[] =>
  drawn.map((error) => (!error ? undefined : error.isBound ? null : error.at));

export const boundsOf = (drawn: (DrawnError | null)[]): (number | null)[] => drawn.map((error) => (error?.isBound ? error.at : null));
