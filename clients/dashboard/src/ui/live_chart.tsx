// A small chart of one quantity that grows while one looks.

import { useRef } from "preact/hooks";
import type uPlot from "uplot";

import { isDark } from "../app/theme";
import { drawBands, drawBounds } from "./draw_intervals";
import type { DrawnError } from "./error_interval";
import { seriesLook } from "./palette";
import { useUPlot } from "./uplot_place";
import "./live_chart.css";

interface Props {
  /** What the chart shows and what it says now, for who does not see it. */
  label: string;
  x: number[];
  /** Of errors where their curve goes. */
  y: (number | null | undefined)[];
  height: number;
  /** One for each x: then both axes are logarithmic, as errors fall, and what is known no better than below a bound is an arrow. */
  errors?: (DrawnError | null)[];
  /** Values hold for the time before them. */
  stepped?: boolean;
  /** The ends of the x axis; those of the data where not given. */
  range?: [number, number];
  /** The series' number in the palette. */
  look?: number;
  /** How the axes' numbers are written; without, there are no axes. */
  axes?: { x: (value: number) => string; y: (value: number) => string };
}

/** Upper bounds are data too, so that the axis reaches them. */
const dataOf = ({ x, y, errors }: Props): uPlot.AlignedData => (errors ? [x, y, errors.map((error) => (error?.isBound ? error.at : null))] : [x, y]);

function optionsOf(Chart: typeof uPlot, latest: { current: Props }, width: number): uPlot.Options {
  const props = latest.current;
  const style = getComputedStyle(document.documentElement);
  const ink = style.getPropertyValue("--muted").trim();
  const line = style.getPropertyValue("--line").trim();
  const { colour } = seriesLook(props.look ?? 0, isDark.peek());
  const axis = (format: (value: number) => string, extra: Partial<uPlot.Axis>): uPlot.Axis => ({
    stroke: ink,
    font: "11px system-ui, sans-serif",
    grid: { stroke: line, width: 1 },
    ticks: { show: false },
    values: (_, splits) => splits.map((split) => (split === null ? null : format(split))),
    ...extra,
  });
  const hidden: uPlot.Axis = { show: false };
  const series: uPlot.Series = { stroke: colour, width: 1.5, fill: props.errors ? undefined : `${colour}22`, points: { show: false } };
  if (props.stepped) series.paths = Chart.paths.stepped!({ align: -1 });
  if (props.errors) series.points = { show: true, size: 3, fill: colour };
  const distribution = props.errors ? 3 : 1;
  const drawn = () => [{ colour, errors: latest.current.errors ?? [] }];
  return {
    width,
    height: props.height,
    legend: { show: false },
    cursor: { show: false },
    padding: props.axes ? [8, 14, 0, 0] : [4, 4, 4, 4],
    scales: {
      x: { time: false, distr: distribution, ...(props.range ? { range: () => latest.current.range! } : {}) },
      // Amounts are seen against nothing: the axis begins at 0 and ends well above the greatest.
      y: { distr: distribution, ...(props.errors ? {} : { range: (_: uPlot, _low: number, high: number) => [0, high > 0 ? high * 1.15 : 1] }) },
    },
    axes: props.axes
      ? [axis(props.axes.x, { size: 22, space: 90 }), axis(props.axes.y, { size: 58, space: 26 })]
      : [hidden, hidden],
    series: [{}, series, ...(props.errors ? [{ width: 0, points: { show: false } }] : [])],
    hooks: props.errors ? { drawAxes: [(chart) => drawBands(chart, drawn())], draw: [(chart) => drawBounds(chart, drawn())] } : {},
  };
}

export function LiveChart(props: Props) {
  const latest = useRef(props);
  latest.current = props;
  const place = useUPlot((Chart, width) => optionsOf(Chart, latest, width), () => dataOf(props), [props.height], [props.x, props.y]);
  return <div ref={place} class="live-chart" role="img" aria-label={props.label} style={{ height: `${props.height}px` }} />;
}
