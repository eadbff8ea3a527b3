// What the figures of a comparison draw: the daemon's mean curves row by row, and what is read off them here: slopes,
// who is lowest when, and which rows are worth their time and memory.

import type { ComparisonReport, ComparisonRow, MeanPoint, Parameters } from "../api/types";
import { metricNamed } from "../api/vocabulary";
import { drawnError } from "../ui/error_interval";

/** "photon mapping, photons 5000", as the daemon writes it: the label and what the sweep gave. */
export function rowName(row: { label: string; parameters: Parameters }): string {
  const swept = Object.entries(row.parameters).map(([name, value]) => `, ${name} ${typeof value === "string" ? value : JSON.stringify(value)}`);
  return row.label + swept.join("");
}

/** The jobs that all is measured against: two films, or one; none where an image was uploaded. */
export const referenceJobs = ({ reference }: Pick<ComparisonReport, "reference">): string[] =>
  reference?.jobs ?? (reference?.job ? [reference.job] : []);

export interface SeriesPoint extends MeanPoint {
  /** The error is not told apart from 0: `error` is what it is below. */
  isBound?: boolean;
}

interface Edges {
  /** 0 or below where a logarithmic axis has no end for it. */
  low: number;
  high: number;
}

export interface Series {
  /** Index of the row in the table; its look follows from it. */
  row: number;
  name: string;
  points: SeriesPoint[];
  /** Point by point; null where nothing is known. */
  band: (Edges | null)[] | null;
  slope: number | null;
  /** How many points have no place on a logarithmic axis: their error is 0 or below, and nothing says what it may be. */
  leftOut: number;
}

/** Of the lowest and highest seed, of the 95 % interval over the seeds, or of what the reference's noise leaves open. */
export type Band = "range" | "interval" | "noise" | "none";

/** With few seeds Student's interval says little but that there are few; the seeds themselves say more. */
const kSeedsForIntervals = 4;
export const defaultBand = (seeds: number, noiseKnown: boolean): Band =>
  seeds < 2 ? (noiseKnown ? "noise" : "none") : seeds < kSeedsForIntervals ? "range" : "interval";

/** Whether a metric was measured by two films, so that what their noise leaves open is known. */
export const isNoiseKnown = (report: ComparisonReport, metric: string): boolean =>
  report.table.some((row) => row.error[metric]?.interval || row.mean_curve[metric]?.some((point) => point.interval));

function edgesOf(point: MeanPoint, band: Band, seeds: number): Edges | null {
  if (band === "noise") return point.interval ? { low: point.interval[0], high: point.interval[1] } : null;
  if (band === "none" || seeds < 2) return null;
  const { low, high } = band === "range" ? { low: point.min, high: point.max } : point;
  return low !== null && high !== null && high > 0 ? { low, high } : null;
}

export function seriesOf(report: ComparisonReport, metric: string, band: Band): Series[] {
  return report.table.map((row, index) => {
    const measured = (row.mean_curve[metric] ?? []).filter((point) => point.seconds > 0);
    const points = measured.flatMap((point): SeriesPoint[] => {
      const drawn = drawnError(point.error, point.interval);
      return drawn ? [{ ...point, error: drawn.at, isBound: drawn.isBound }] : [];
    });
    const edges = points.map((point) => edgesOf(point, band, row.seeds));
    return {
      row: index,
      name: rowName(row),
      points,
      band: edges.some(Boolean) ? edges : null,
      slope: fittedSlope(points),
      leftOut: measured.length - points.length,
    };
  });
}

const kTailDecades = 1;
const kFewestPoints = 3;

/**
 * The slope of log error over log time by least squares, over the last decade of time: what comes before is the method's
 * start. Null with fewer than three points there, or all at one time; upper bounds are none.
 */
export function fittedSlope(measured: Pick<SeriesPoint, "seconds" | "error" | "isBound">[]): number | null {
  const points = measured.filter((point) => !point.isBound);
  const last = points.at(-1)?.seconds ?? 0;
  const tail = points.filter((point) => point.seconds >= last / 10 ** kTailDecades * (1 - 1e-9));
  if (tail.length < kFewestPoints) return null;
  const x = tail.map((point) => Math.log(point.seconds));
  const y = tail.map((point) => Math.log(point.error));
  const mean = (values: number[]) => values.reduce((sum, value) => sum + value, 0) / values.length;
  const [mx, my] = [mean(x), mean(y)];
  const spread = x.reduce((sum, value) => sum + (value - mx) ** 2, 0);
  if (spread < 1e-12) return null;
  return x.reduce((sum, value, i) => sum + (value - mx) * (y[i]! - my), 0) / spread;
}

/** How a metric falls with time where the error is nothing but independent noise; null where no law says so. */
export const idealSlope = (metric: string): number | null => metricNamed(metric)?.slope ?? null;

/**
 * The error at a time, straight in log-log between points as the daemon takes it; beside an upper bound it is one too.
 * Null outside the curve's span.
 */
export function readingAt(points: SeriesPoint[], seconds: number): { error: number; isBound: boolean } | null {
  const after = points.findIndex((point) => point.seconds >= seconds);
  if (after < 0) return null;
  const b = points[after]!;
  if (b.seconds === seconds) return { error: b.error, isBound: !!b.isBound };
  const a = points[after - 1];
  if (!a) return null;
  const share = Math.log(seconds / a.seconds) / Math.log(b.seconds / a.seconds);
  return { error: a.error * (b.error / a.error) ** share, isBound: !!a.isBound || !!b.isBound };
}

export const errorAt = (points: SeriesPoint[], seconds: number): number | null => readingAt(points, seconds)?.error ?? null;

export interface Stretch {
  row: number;
  from: number;
  to: number;
}

/** Every time at which some curve has a point or two curves cross, rising. */
function turningTimes(series: Series[]): number[] {
  const times = new Set(series.flatMap((one) => one.points.map((point) => point.seconds)));
  const sorted = [...times].sort((a, b) => a - b);
  const crossings: number[] = [];
  for (let i = 1; i < sorted.length; ++i) {
    const [from, to] = [sorted[i - 1]!, sorted[i]!];
    for (let a = 0; a < series.length; ++a)
      for (let b = a + 1; b < series.length; ++b) {
        const at = (one: Series, time: number) => Math.log(errorAt(one.points, time) ?? NaN);
        const before = at(series[a]!, from) - at(series[b]!, from);
        const after = at(series[a]!, to) - at(series[b]!, to);
        if (before * after < 0) crossings.push(from * (to / from) ** (before / (before - after)));
      }
  }
  return [...sorted, ...crossings].sort((a, b) => a - b);
}

/**
 * Who has the lowest error when: the Pareto front of time and error, as stretches one after the other. A curve counts
 * where it was measured, and its last value from then on: a film one stops with does not get worse. Where no more is known
 * than an upper bound, it counts as that.
 */
export function bestByTime(series: Series[]): Stretch[] {
  const times = turningTimes(series);
  const stretches: Stretch[] = [];
  for (let i = 1; i < times.length; ++i) {
    const [from, to] = [times[i - 1]!, times[i]!];
    const middle = Math.sqrt(from * to);
    let best: { row: number; error: number } | null = null;
    for (const one of series) {
      const last = one.points.at(-1);
      const error = last && middle > last.seconds ? last.error : errorAt(one.points, middle);
      if (error !== null && (!best || error < best.error)) best = { row: one.row, error };
    }
    if (!best) continue;
    const previous = stretches.at(-1);
    if (previous?.row === best.row) previous.to = to;
    else stretches.push({ row: best.row, from, to });
  }
  return stretches;
}

/**
 * Rows on the front of time, memory and error: at some time nobody with as little memory has an error as low. A row whose
 * memory is not known is none of them, and stands in nobody's way.
 */
export function frontWithMemory(series: Series[], rows: ComparisonRow[]): number[] {
  const bytes = (row: number) => rows[row]?.peak_bytes ?? null;
  const known = series.filter((one) => one.points.length > 0 && bytes(one.row) !== null);
  return known
    .filter((one) => {
      const rivals = known.filter((other) => other.row !== one.row && bytes(other.row)! <= bytes(one.row)!);
      return bestByTime([one, ...rivals]).some((stretch) => stretch.row === one.row);
    })
    .map((one) => one.row);
}

/** Ticks of a logarithmic axis of bytes: powers of two, no more than eight or so. */
export function byteTicks(low: number, high: number): number[] {
  const [first, last] = [Math.ceil(Math.log2(low)), Math.floor(Math.log2(high))];
  const every = Math.max(1, Math.ceil((last - first + 1) / 8));
  return Array.from({ length: Math.max(0, Math.floor((last - first) / every) + 1) }, (_, i) => 2 ** (first + i * every));
}

/** Ticks of a logarithmic axis: powers of ten, or 1-2-5 where the span is short. */
export function logTicks(low: number, high: number): number[] {
  const decades = Math.log10(high / low);
  const digits = decades < 2.5 ? [1, 2, 5] : [1];
  const every = Math.max(1, Math.ceil(decades / 8));
  const ticks: number[] = [];
  for (let power = Math.floor(Math.log10(low)) - 1; power <= Math.ceil(Math.log10(high)); ++power)
    for (const digit of digits) {
      const value = Number(`${digit}e${power}`);
      if (value >= low * (1 - 1e-9) && value <= high * (1 + 1e-9) && power % every === 0) ticks.push(value);
    }
  return ticks;
}
