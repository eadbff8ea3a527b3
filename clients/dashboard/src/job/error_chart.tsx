// Error against time, on two logarithmic axes, growing while the job runs. The metrics are chosen; the target is a line.

import "uplot/dist/uPlot.min.css";

import { useMemo, useState } from "preact/hooks";
import type uPlot from "uplot";

import type { CurvePoint, StopConditions } from "../api/types";
import { isDark } from "../app/theme";
import { countText, numberText, plainName, secondsText } from "../ui/format";
import { seriesLook } from "../ui/palette";
import { useUPlot } from "../ui/uplot_place";

interface Props {
  curve: CurvePoint[];
  target: StopConditions["target"];
  against: "seconds" | "passes";
  metrics: string[];
  /** All there are, so that a metric keeps its colour whichever are shown. */
  all: string[];
}

const kHeight = 300;

const usable = (value: number | null | undefined): number | null => (typeof value === "number" && value > 0 && Number.isFinite(value) ? value : null);

function dataOf({ curve, metrics, against, target }: Props): uPlot.AlignedData {
  const points = curve.filter((point) => point[against] > 0 && metrics.some((metric) => usable(point.metrics[metric]) !== null));
  const line = target && metrics.includes(target.metric) ? [points.map(() => target.value)] : [];
  return [points.map((point) => point[against]), ...metrics.map((metric) => points.map((point) => usable(point.metrics[metric]))), ...line];
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

function optionsOf(props: Props, width: number): uPlot.Options {
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
      { ...axis, size: 64, filter: labelled, values: written((value) => numberText(value)) },
    ],
    series: [
      { label: props.against === "seconds" ? "time" : "passes", value: (_, value) => (value === null ? "–" : xText(value)) },
      ...props.metrics.map((metric): uPlot.Series => {
        const look = seriesLook(props.all.indexOf(metric), isDark.peek());
        return {
          label: plainName(metric),
          stroke: look.colour,
          dash: look.dash,
          width: 2,
          spanGaps: true,
          points: { show: true, size: 5 },
          value: (_, value) => numberText(value),
        };
      }),
      ...(props.target && props.metrics.includes(props.target.metric)
        ? [{ label: "target", stroke: colour("--muted"), dash: [4, 4], width: 1.5, points: { show: false }, value: (_: uPlot, value: number) => numberText(value) } satisfies uPlot.Series]
        : []),
    ],
  };
}

function Chart(props: Props) {
  const remake = [props.metrics.join(), props.against, props.target?.value];
  const place = useUPlot((_, width) => optionsOf(props, width), () => dataOf(props), remake, [props.curve]);
  const last = props.curve.at(-1);
  const now = last ? props.metrics.map((metric) => `${plainName(metric)} ${numberText(last.metrics[metric])}`).join(", ") : "";
  return <div ref={place} class="job-chart" role="img" aria-label={`Error against ${props.against}; at the end ${now}`} />;
}

export function ErrorCurve({ curve, target, running }: { curve: CurvePoint[] | null; target: StopConditions["target"]; running: boolean }) {
  const all = useMemo(() => [...new Set((curve ?? []).flatMap((point) => Object.keys(point.metrics)))].sort(), [curve]);
  const measured = all.filter((metric) => curve!.some((point) => usable(point.metrics[metric]) !== null));
  const [chosen, setChosen] = useState<string[] | null>(null);
  const [against, setAgainst] = useState<"seconds" | "passes">("seconds");
  const first = target && measured.includes(target.metric) ? target.metric : measured.includes("relative_mse") ? "relative_mse" : measured[0];
  const shown = (chosen ?? (first ? [first] : [])).filter((metric) => measured.includes(metric));
  if (measured.length === 0)
    return <p class="muted">{running ? "The first points come after the second pass." : "Nothing was measured: an error needs two passes at least, or a reference."}</p>;
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
      {shown.length > 0 ? <Chart curve={curve!} target={target} against={against} metrics={shown} all={measured} /> : <p class="muted">Choose a metric.</p>}
    </>
  );
}
