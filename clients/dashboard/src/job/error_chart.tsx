// Error against time, on two logarithmic axes, growing while the job runs: with what its reference's noise leaves open as a
// band, and upper bounds where no more is known. The metrics are chosen; the target is a line.

import "uplot/dist/uPlot.min.css";

import { useMemo, useRef, useState } from "preact/hooks";
import type uPlot from "uplot";

import type { CurvePoint, StopConditions } from "../api/types";
import { isDark } from "../app/theme";
import { drawBands, drawBounds } from "../ui/draw_intervals";
import { errorWithInterval } from "../ui/error_interval";
import { countText, kNone, numberText, plainName, secondsText } from "../ui/format";
import { seriesLook } from "../ui/palette";
import { useUPlot } from "../ui/uplot_place";
import { boundsOf, drawnAt, errorPoints, lineOf, type ErrorPoints } from "./error_points";

interface Props {
  points: ErrorPoints;
  target: StopConditions["target"];
  against: "seconds" | "passes";
  metrics: string[];
  /** All there are, so that a metric keeps its colour whichever are shown. */
  all: string[];
}

const kHeight = 300;

/** Those of the metrics, by their place, of which some points are but upper bounds. */
const bounded = ({ points }: Props): number[] => points.drawn.flatMap((drawn, index) => (drawn.some((error) => error?.isBound) ? [index] : []));

/** The curves, the upper bounds of those that have some, the target. */
function dataOf(props: Props): uPlot.AlignedData {
  const { points, metrics, target } = props;
  const line = target && metrics.includes(target.metric) ? [points.x.map(() => target.value)] : [];
  return [points.x, ...points.drawn.map(lineOf), ...bounded(props).map((index) => boundsOf(points.drawn[index]!)), ...line];
}

/** The powers of ten about the values, so that a short curve has an axis too. */
function decades(low: number, high: number): [number, number] {
  if (!(low > 0) || !(high > 0)) return [0.1, 1];
  const [from, to] = [10 ** Math.floor(Math.log10(low)), 10 ** Math.ceil(Math.log10(high))];
  return from === to ? [from, to * 10] : [from, to];
}

/**
 * From the low value rounded down to one digit. uPlot steps from a logarithmic axis's low end itself, and from 0.0096 its
 * rounding comes to a step of 0.011 and then to 0, so that the axis never ends.
 */
function fromDigit(low: number, high: number): [number, number] {
  if (low === high) return fromDigit(low / 2, high * 2);
  const [digits, power] = low.toExponential().split("e");
  return [Number(`${Math.floor(Number(digits))}e${power}`), high];
}

/** Decades are labelled; where there are few, 2 and 5 of each too. */
function labelled(_: uPlot, splits: number[]): (number | null)[] {
  const few = splits.length > 0 && splits.at(-1)! / splits[0]! < 30;
  return splits.map((split) => {
    const digit = Math.round(split / 10 ** Math.floor(Math.log10(split) + 1e-9));
    return digit === 1 || digit === 10 || (few && (digit === 2 || digit === 5)) ? split : null;
  });
}

function optionsOf(latest: { current: Props }, width: number): uPlot.Options {
  const props = latest.current;
  const lookOf = (index: number) => seriesLook(props.all.indexOf(props.metrics[index]!), isDark.peek());
  // Those that the legend has not switched off.
  const intervals = (chart: uPlot, first: number, which: number[]) =>
    which.flatMap((index, i) => (chart.series[first + i]!.show ? [{ colour: lookOf(index).colour, errors: latest.current.points.drawn[index]! }] : []));
  const everyMetric = props.metrics.map((_, index) => index);
  const style = getComputedStyle(document.documentElement);
  const colour = (name: string) => style.getPropertyValue(name).trim();
  const axis: uPlot.Axis = {
    stroke: colour("--muted"),
    font: "12px system-ui, sans-serif",
    labelFont: "12px system-ui, sans-serif",
    grid: { stroke: colour("--line"), width: 1 },
    ticks: { stroke: colour("--line"), width: 1 },
  };
  const xText = (value: number) => (props.against === "seconds" ? secondsText(value) : countText(value));
  const written = (text: (value: number) => string) => (_: uPlot, values: (number | null)[]) => values.map((value) => (value === null ? "" : text(value)));
  return {
    width,
    height: kHeight,
    legend: { live: true },
    cursor: { drag: { x: false, y: false } },
    scales: {
      x: { time: false, distr: 3, range: (_, low, high) => fromDigit(low, high) },
      y: { distr: 3, range: (_, low, high) => decades(low, high) },
    },
    axes: [
      { ...axis, label: props.against === "seconds" ? "render time" : "passes", labelSize: 20, size: 34, filter: labelled, values: written(xText), space: 70 },
      { ...axis, label: props.metrics.length === 1 ? plainName(props.metrics[0]!) : "error", labelSize: 20, size: 56, filter: labelled, values: written((value) => numberText(value)) },
    ],
    series: [
      { label: props.against === "seconds" ? "time" : "passes", value: (_, value) => (value === null ? kNone : xText(value)) },
      ...props.metrics.map((metric, index): uPlot.Series => {
        const look = lookOf(index);
        return {
          label: plainName(metric),
          stroke: look.colour,
          dash: look.dash,
          width: 2,
          points: { show: true, size: 5 },
          value: (_chart, value: number | null | undefined, _series, at) => {
            const error = at == null ? null : latest.current.points.drawn[index]![at];
            const known = error && !error.isBound && error.least < error.greatest;
            return known ? errorWithInterval(value, [error.least, error.greatest]) : numberText(value);
          },
        };
      }),
      ...bounded(props).map((index): uPlot.Series => ({
        label: `${plainName(props.metrics[index]!)}, upper bound`,
        stroke: lookOf(index).colour,
        width: 0,
        points: { show: false }, // an arrow each, drawn by the hook
        value: (_, value: number | null | undefined) => numberText(value),
      })),
      ...(props.target && props.metrics.includes(props.target.metric)
        ? [{ label: "target", stroke: colour("--muted"), dash: [4, 4], width: 1.5, points: { show: false }, value: (_: uPlot, value: number) => numberText(value) } satisfies uPlot.Series]
        : []),
    ],
    hooks: {
      drawAxes: [(chart) => drawBands(chart, intervals(chart, 1, everyMetric))],
      draw: [(chart) => drawBounds(chart, intervals(chart, 1 + props.metrics.length, bounded(props)))],
    },
  };
}

function Chart(props: Props & { last: CurvePoint | undefined }) {
  const latest = useRef<Props>(props);
  latest.current = props;
  const remake = [props.metrics.join(), props.against, props.target?.value, bounded(props).join()];
  const place = useUPlot((_, width) => optionsOf(latest, width), () => dataOf(latest.current), remake, [props.points]);
  const { last } = props;
  const now = last ? props.metrics.map((metric) => `${plainName(metric)} ${errorWithInterval(last.metrics[metric], last.intervals?.[metric])}`).join(", ") : "";
  return <div ref={place} class="job-chart" role="img" aria-label={`Error against ${props.against}; at the end ${now}`} />;
}

/** What the marks are, and what has none. */
function notesOf({ drawn, leftOut }: ErrorPoints): string {
  const errors = drawn.flat();
  const notes: string[] = [];
  if (errors.some((error) => error && !error.isBound && error.least < error.greatest)) notes.push("Bands: what the reference's noise leaves open, at 90 %.");
  if (errors.some((error) => error?.isBound)) notes.push("Arrows: upper bounds, where the error is not told apart from 0.");
  if (leftOut > 0) notes.push(`${leftOut === 1 ? "1 value is" : `${leftOut} values are`} 0 or below, which a logarithmic axis cannot show.`);
  return notes.join(" ");
}

export function ErrorCurve({ curve, target, running }: { curve: CurvePoint[] | null; target: StopConditions["target"]; running: boolean }) {
  const all = useMemo(() => [...new Set((curve ?? []).flatMap((point) => Object.keys(point.metrics)))].sort(), [curve]);
  const measured = all.filter((metric) => curve!.some((point) => drawnAt(point, metric)));
  const [chosen, setChosen] = useState<string[] | null>(null);
  const [against, setAgainst] = useState<"seconds" | "passes">("seconds");
  const first = target && measured.includes(target.metric) ? target.metric : measured.includes("relative_mse") ? "relative_mse" : measured[0];
  const shown = (chosen ?? (first ? [first] : [])).filter((metric) => measured.includes(metric));
  const points = useMemo(() => errorPoints(curve ?? [], shown, against), [curve, shown.join(), against]);
  if (measured.length === 0)
    return <p class="muted">{running ? "The first points come after the second pass." : "Nothing was measured: an error needs two passes at least, or a reference."}</p>;
  const notes = notesOf(points);
  const toggle = (metric: string) => setChosen(shown.includes(metric) ? shown.filter((other) => other !== metric) : [...shown, metric]);
  return (
    <>
      <div class="row job-metrics" role="group" aria-label="Metrics">
        {measured.map((metric) => (
          <button key={metric} class="small" aria-pressed={shown.includes(metric)} onClick={() => toggle(metric)}>
            {plainName(metric)}
          </button>
        ))}
        <label class="row small job-against">
          against
          <select value={against} onChange={(event) => setAgainst(event.currentTarget.value as "seconds" | "passes")}>
            <option value="seconds">render time</option>
            <option value="passes">passes</option>
          </select>
        </label>
      </div>
      {shown.length > 0 ? <Chart points={points} last={curve!.at(-1)} target={target} against={against} metrics={shown} all={measured} /> : <p class="muted">Choose a metric.</p>}
      {notes && <p class="hint">{notes}</p>}
    </>
  );
}
