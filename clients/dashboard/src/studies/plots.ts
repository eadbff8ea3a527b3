// The figures themselves, drawn by Observable Plot; fetched when a study has something to draw. Each figure is a
// function of its data and its look, so that the page and the saved SVG cannot differ in what they show.

import { areaY, axisX, axisY, dot, frame, gridX, gridY, line, plot, ruleY, text } from "@observablehq/plot";

import { bytesText, numberText, secondsText } from "../ui/format";
import { seriesLook } from "../ui/palette";
import { memoryFront, type MemoryPoint } from "./memory";
import { bestByTime, byteTicks, errorAt, logTicks, type Series } from "./series";

/** Fixed, for Plot writes a style element with it, which the page's policy permits by its hash. */
export const kPlotClass = "study-plot";

export interface PlotLook {
  dark: boolean;
  width: number;
  height: number;
}

interface Inks {
  text: string;
  muted: string;
  grid: string;
  front: string;
}

// tokens.css, as presentation attributes that an SVG by itself carries along.
const kInks: Record<"light" | "dark", Inks> = {
  light: { text: "#15202b", muted: "#53606d", grid: "#d5dde4", front: "#c9d6e0" },
  dark: { text: "#e6edf3", muted: "#9fb0bf", grid: "#2a3742", front: "#3a4b59" },
};
const inksOf = (dark: boolean) => kInks[dark ? "dark" : "light"];

const kMargins = { marginLeft: 64, marginRight: 20, marginTop: 24, marginBottom: 44 };
const kFontSize = 12;
const dashText = (dash: number[]) => (dash.length ? dash.join(" ") : undefined);

/** Widened to what a logarithmic axis can show: some air on both sides, never a single value. */
function logDomain(values: number[]): [number, number] {
  const [low, high] = [Math.min(...values), Math.max(...values)];
  const air = Math.max(1.15, (high / low) ** 0.04);
  return low === high ? [low / 2, high * 2] : [low / air, high * air];
}

interface AxisInput {
  x: [number, number];
  y: [number, number];
  xTicks: number[];
  xText: (value: number) => string;
  yText: (value: number) => string;
  xLabel: string;
  yLabel: string;
}

function frameAndAxes(inks: Inks, axis: AxisInput) {
  const { xTicks } = axis;
  const yTicks = logTicks(...axis.y);
  return [
    gridX(xTicks, { stroke: inks.grid, strokeOpacity: 1 }),
    gridY(yTicks, { stroke: inks.grid, strokeOpacity: 1 }),
    frame({ stroke: inks.grid }),
    axisX(xTicks, { tickFormat: axis.xText, fill: inks.muted, stroke: inks.muted, tickSize: 4, fontSize: kFontSize, label: axis.xLabel, labelAnchor: "right", labelArrow: "none" }),
    axisY(yTicks, { tickFormat: axis.yText, fill: inks.muted, stroke: inks.muted, tickSize: 4, fontSize: kFontSize, label: axis.yLabel, labelArrow: "none" }),
  ];
}

export interface ErrorTimeInput {
  metric: string;
  series: Series[];
  /** Rows that are switched off. */
  hidden: ReadonlySet<number>;
  /** The reference's own noise by this metric. */
  noise: number | null;
  ideal: number | null;
  showFront: boolean;
}

/** A line of a slope through the upper right of what is drawn, to hold curves against. */
function guideOf(series: Series[], slope: number): { seconds: number; error: number }[] {
  const points = series.flatMap((one) => one.points);
  const [first, last] = [Math.min(...points.map((point) => point.seconds)), Math.max(...points.map((point) => point.seconds))];
  const top = Math.max(...points.map((point) => point.error * point.seconds ** -slope));
  const from = last / (last / first) ** 0.6;
  return [from, last].map((seconds) => ({ seconds, error: top * seconds ** slope }));
}

/** To assistive technology a figure is one image; Plot names its parts, which have no role that could be named. */
function asImage<T extends Element>(figure: T): T {
  figure.setAttribute("role", "img");
  for (const part of figure.querySelectorAll("[aria-label]")) part.removeAttribute("aria-label");
  return figure;
}

/** Error against time on logarithmic axes; null where nothing has been measured. */
export function errorTimePlot(input: ErrorTimeInput, look: PlotLook) {
  const inks = inksOf(look.dark);
  const shown = input.series.filter((one) => !input.hidden.has(one.row) && one.points.length > 0);
  if (shown.length === 0) return null;
  const guide = input.ideal !== null && shown.some((one) => one.points.length > 1) ? guideOf(shown, input.ideal) : [];
  const errors = shown.flatMap((one) => [...one.points.map((point) => point.error), ...(one.band ?? []).flatMap((edge) => [edge.low, edge.high])]);
  // A band of two seeds may go over many decades: it is cut where it would leave no room for the curves.
  const centre = logDomain([...shown.flatMap((one) => one.points.map((point) => point.error)), ...(input.noise ? [input.noise] : [])]);
  const y = logDomain(errors.map((error) => Math.min(Math.max(error, centre[0] / 3), centre[1] * 3)).concat(input.noise ? [input.noise] : []));
  const x = logDomain(shown.flatMap((one) => one.points.map((point) => point.seconds)));
  const front = input.showFront
    ? bestByTime(shown).flatMap((stretch) => {
        const points = shown.find((one) => one.row === stretch.row)!.points;
        const times = [stretch.from, ...points.map((point) => point.seconds).filter((time) => time > stretch.from && time < stretch.to), stretch.to];
        return times.map((seconds) => ({ seconds, error: errorAt(points, seconds) ?? points.at(-1)!.error, part: stretch.from }));
      })
    : [];
  const drawn = plot({
    className: kPlotClass,
    width: look.width,
    height: look.height,
    ...kMargins,
    ariaLabel: `${input.metric} against time, both axes logarithmic`,
    style: { background: "transparent", color: inks.text },
    x: { type: "log", domain: x, clamp: true },
    y: { type: "log", domain: y, clamp: true },
    marks: [
      ...frameAndAxes(inks, { x, y, xTicks: logTicks(...x), xText: secondsText, yText: (value) => numberText(value), xLabel: "render time", yLabel: input.metric }),
      front.length > 1 ? line(front, { x: "seconds", y: "error", z: "part", stroke: inks.front, strokeWidth: 11, strokeLinecap: "round", strokeLinejoin: "round" }) : null,
      ...shown.map((one) =>
        one.band
          ? areaY(
              one.points.map((point, i) => ({ seconds: point.seconds, ...one.band![i]! })),
              { x: "seconds", y1: "low", y2: "high", fill: seriesLook(one.row, look.dark).colour, fillOpacity: 0.16 },
            )
          : null,
      ),
      input.noise ? ruleY([input.noise], { stroke: inks.muted, strokeDasharray: "2 4" }) : null,
      input.noise
        ? text([input.noise], { y: (value: number) => value, frameAnchor: "right", dy: -7, dx: -4, text: () => "noise of the reference", fill: inks.muted, fontSize: kFontSize - 1, textAnchor: "end" })
        : null,
      guide.length ? line(guide, { x: "seconds", y: "error", stroke: inks.muted, strokeDasharray: "1 4", strokeLinecap: "round", strokeWidth: 1.5, clip: true }) : null,
      guide.length
        ? text(guide.slice(0, 1), { x: "seconds", y: "error", text: () => `slope ${numberText(input.ideal)}`, dy: -8, dx: 2, textAnchor: "start", fill: inks.muted, fontSize: kFontSize - 1, clip: false })
        : null,
      ...shown.flatMap((one) => {
        const { colour, dash, symbol } = seriesLook(one.row, look.dark);
        return [
          line(one.points, { x: "seconds", y: "error", stroke: colour, strokeWidth: 2, strokeDasharray: dashText(dash) }),
          dot(one.points, { x: "seconds", y: "error", fill: colour, symbol, r: 3.2 }),
        ];
      }),
    ],
  });
  return asImage(drawn as typeof drawn & SVGSVGElement);
}

/** The error at the end against the memory it took; null where no memory is known. */
export function memoryPlot(metric: string, points: MemoryPoint[], look: PlotLook) {
  const inks = inksOf(look.dark);
  if (points.length === 0) return null;
  const x = logDomain(points.map((point) => point.bytes));
  const y = logDomain(points.map((point) => point.error));
  // Room for the names, and for a power of two at least on either side.
  const wide: [number, number] = [x[0] / 1.6, x[1] * 1.6];
  const front = memoryFront(points);
  const drawn = plot({
    className: kPlotClass,
    width: look.width,
    height: look.height,
    ...kMargins,
    ariaLabel: `${metric} at the end against peak memory, both axes logarithmic`,
    style: { background: "transparent", color: inks.text },
    x: { type: "log", domain: wide },
    y: { type: "log", domain: y },
    marks: [
      ...frameAndAxes(inks, { x: wide, y, xTicks: byteTicks(...wide), xText: bytesText, yText: (value) => numberText(value), xLabel: "peak memory", yLabel: `${metric} at the end` }),
      front.length > 1 ? line(front, { x: "bytes", y: "error", curve: "step-after", stroke: inks.front, strokeWidth: 5, strokeLinejoin: "round" }) : null,
      ...points.map((point) => {
        const { colour, symbol } = seriesLook(point.row, look.dark);
        return dot([point], { x: "bytes", y: "error", fill: colour, symbol, r: 6 });
      }),
      ...points.map((point) => {
        const right = Math.log(point.bytes / wide[0]) / Math.log(wide[1] / wide[0]) > 0.6;
        return text([point], { x: "bytes", y: "error", text: "name", dx: right ? -11 : 11, textAnchor: right ? "end" : "start", fill: inks.text, fontSize: kFontSize });
      }),
    ],
  });
  return asImage(drawn as typeof drawn & SVGSVGElement);
}
