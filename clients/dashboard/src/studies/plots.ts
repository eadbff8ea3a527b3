// The figures themselves. Each is a function of its data and its look, so that the page and the saved SVG cannot differ in
// what they show.

import { bytesText, numberText, secondsText } from "../ui/format";
import { seriesLook } from "../ui/palette";
import type { Floor } from "./bias";
import { LogFigure } from "./log_figure";
import { memoryFront, type MemoryPoint } from "./memory";
import { bestByTime, byteTicks, errorAt, logTicks, type Series, type SeriesPoint } from "./series";
import { kSymbols } from "./symbols";

export interface PlotLook {
  dark: boolean;
  width: number;
  height: number;
}

// tokens.css, as presentation attributes that an SVG by itself carries along.
const kInks = {
  light: { text: "#15202b", muted: "#53606d", grid: "#d5dde4", front: "#c9d6e0" },
  dark: { text: "#e6edf3", muted: "#9fb0bf", grid: "#2a3742", front: "#3a4b59" },
};
const inksOf = (dark: boolean) => kInks[dark ? "dark" : "light"];

const kNoteSize = 11;
const dashText = (dash: number[]) => (dash.length ? dash.join(" ") : undefined);

/** Widened to what a logarithmic axis can show: some air on both sides, never a single value. */
function logDomain(values: number[]): [number, number] {
  const [low, high] = [Math.min(...values), Math.max(...values)];
  const air = Math.max(1.15, (high / low) ** 0.04);
  return low === high ? [low / 2, high * 2] : [low / air, high * air];
}

export interface ErrorTimeInput {
  metric: string;
  series: Series[];
  /** Rows that are switched off. */
  hidden: ReadonlySet<number>;
  /** The reference's own noise by this metric, where it has a part in the errors. */
  noise: number | null;
  /** What rows do not go below. */
  floors: Floor[];
  ideal: number | null;
  showFront: boolean;
}

const onPaper = ({ seconds, error }: { seconds: number; error: number }) => ({ x: seconds, y: error });
const isValue = (point: SeriesPoint): boolean => !point.isBound;

/** A line of a slope through the upper right of what is drawn, to hold curves against; none where there are no curves. */
function guideOf(series: Series[], slope: number, most: number): { seconds: number; error: number }[] {
  const points = series.flatMap((one) => one.points.filter(isValue));
  if (!series.some((one) => one.points.filter(isValue).length > 1)) return [];
  const [first, last] = [Math.min(...points.map((point) => point.seconds)), Math.max(...points.map((point) => point.seconds))];
  const top = Math.max(...points.map((point) => point.error * point.seconds ** -slope));
  const from = Math.max(last / (last / first) ** 0.6, (most / top) ** (1 / slope));
  return from < last ? [from, last].map((seconds) => ({ seconds, error: top * seconds ** slope })) : [];
}

/** The lowest curves, part by part. */
function frontOf(series: Series[]): { seconds: number; error: number }[][] {
  return bestByTime(series).map((stretch) => {
    const points = series.find((one) => one.row === stretch.row)!.points;
    const times = [stretch.from, ...points.map((point) => point.seconds).filter((time) => time > stretch.from && time < stretch.to), stretch.to];
    return times.map((seconds) => ({ seconds, error: errorAt(points, seconds) ?? points.at(-1)!.error }));
  });
}

/** Error against time on logarithmic axes; null where nothing has been measured. */
export function errorTimePlot(input: ErrorTimeInput, look: PlotLook): LogFigure | null {
  const inks = inksOf(look.dark);
  const shown = input.series.filter((one) => !input.hidden.has(one.row) && one.points.length > 0);
  if (shown.length === 0) return null;
  const floors = input.floors.filter((floor) => shown.some((one) => one.row === floor.row));
  const levels = [...(input.noise ? [input.noise] : []), ...floors.map((floor) => floor.error)];
  const errors = shown.flatMap((one) => [...one.points.map((point) => point.error), ...(one.band ?? []).flatMap((edge) => (edge ? [edge.low, edge.high] : []))]);
  // A band of two seeds may go over many decades: it is cut where it would leave no room for the curves.
  const centre = logDomain([...shown.flatMap((one) => one.points.map((point) => point.error)), ...levels]);
  // An arrow goes down from an upper bound, and has room there.
  if (shown.some((one) => !one.points.every(isValue))) levels.push(centre[0] / 1.4);
  const y = logDomain(errors.map((error) => Math.min(Math.max(error, centre[0] / 3), centre[1] * 3)).concat(levels));
  const x = logDomain(shown.flatMap((one) => one.points.map((point) => point.seconds)));
  const figure = new LogFigure({ ...look, ...inks }, `${input.metric} against time, both axes logarithmic`, x, y);
  figure.axes({ label: "render time", ticks: logTicks(...x), text: secondsText }, { label: input.metric, ticks: logTicks(...y), text: (value) => numberText(value) });
  if (input.showFront)
    for (const part of frontOf(shown)) figure.line(part.map(onPaper), { stroke: inks.front, "stroke-width": 11, "stroke-linecap": "round" });
  for (const { row, points, band } of shown)
    if (band)
      figure.band(
        band.map((edge, i) => edge && { x: points[i]!.seconds, ...edge }),
        seriesLook(row, look.dark).colour,
      );
  if (input.noise) figure.level(input.noise, "noise of the reference", "end", { stroke: inks.muted, "stroke-dasharray": "2 4" });
  let under: number | undefined; // floors that lie close have their notes one above the other
  for (const { row, name, error } of [...floors].sort((a, b) => a.error - b.error)) {
    const dots = { stroke: seriesLook(row, look.dark).colour, "stroke-dasharray": "1.5 4", "stroke-linecap": "round", "stroke-width": 1.8 };
    under = figure.level(error, `${name}: reaches no less than ${numberText(error)}`, "start", dots, under);
  }
  const guide = input.ideal === null ? [] : guideOf(shown, input.ideal, y[1]);
  if (guide.length > 0) {
    figure.line(guide.map(onPaper), { stroke: inks.muted, "stroke-dasharray": "1 4", "stroke-linecap": "round", "stroke-width": 1.5 });
    figure.note(onPaper(guide[0]!), [2, -8], `slope ${numberText(input.ideal)}`, { fill: inks.muted, "font-size": kNoteSize });
  }
  for (const { row, points } of shown) {
    const { colour, dash, symbol } = seriesLook(row, look.dark);
    figure.line(points.map((point) => (isValue(point) ? onPaper(point) : null)), { stroke: colour, "stroke-width": 2, "stroke-dasharray": dashText(dash) });
    for (const point of points)
      if (isValue(point)) figure.symbol(onPaper(point), kSymbols[symbol], colour);
      else figure.bound(onPaper(point), colour);
  }
  return figure;
}

/** The error at the end against the memory it took; null where no memory is known. */
export function memoryPlot(metric: string, points: MemoryPoint[], look: PlotLook): LogFigure | null {
  const inks = inksOf(look.dark);
  if (points.length === 0) return null;
  const tight = logDomain(points.map((point) => point.bytes));
  const y = logDomain(points.map((point) => point.error));
  // Room for the names, and for a power of two at least on either side.
  const x: [number, number] = [tight[0] / 1.6, tight[1] * 1.6];
  const figure = new LogFigure({ ...look, ...inks }, `${metric} at the end against peak memory, both axes logarithmic`, x, y);
  figure.axes({ label: "peak memory", ticks: byteTicks(...x), text: bytesText }, { label: `${metric} at the end`, ticks: logTicks(...y), text: (value) => numberText(value) });
  const at = (point: MemoryPoint) => ({ x: point.bytes, y: point.error });
  // No error is better than the front's until the next memory.
  const steps = memoryFront(points).flatMap((point, i, all) => (i === 0 ? [at(point)] : [{ x: point.bytes, y: all[i - 1]!.error }, at(point)]));
  if (steps.length > 1) figure.line(steps, { stroke: inks.front, "stroke-width": 5 });
  for (const point of points) {
    const { colour, symbol } = seriesLook(point.row, look.dark);
    if (point.isBound) figure.bound(at(point), colour);
    else figure.symbol(at(point), kSymbols[symbol], colour, 1.5);
  }
  figure.names(
    points.map((point) => ({ ...at(point), text: point.name })),
    { fill: inks.text },
  );
  return figure;
}
