// Intervals and upper bounds of errors in a chart by uPlot, on a logarithmic axis: a band about the curve, a whisker where
// a point stands alone, and an arrow down from where no more is known than an upper bound.

import type uPlot from "uplot";

import type { DrawnError } from "./error_interval";

const kBandOpacity = 0.18;
const kArrow = { stem: 13, head: 4, cap: 5 }; // CSS pixels
const kLine = 1.5;

interface IntervalSeries {
  colour: string;
  /** One for each of the chart's x; null where nothing is drawn. */
  errors: (DrawnError | null)[];
}

/** Draws within the plot's own area; `scale` is device pixels in a CSS pixel. */
function clipped(chart: uPlot, draw: (context: CanvasRenderingContext2D, scale: number) => void): void {
  const { ctx, bbox } = chart;
  ctx.save();
  ctx.beginPath();
  const beside = kArrow.cap * devicePixelRatio; // the last point stands at the very edge
  ctx.rect(bbox.left - beside, bbox.top, bbox.width + 2 * beside, bbox.height);
  ctx.clip();
  ctx.setLineDash([]); // as a series may have left it
  draw(ctx, devicePixelRatio);
  ctx.restore();
}

/** Below what the axis shows there is its edge. */
function heightOf(chart: uPlot, error: number): number {
  return error > (chart.scales.y!.min ?? 0) ? chart.valToPos(error, "y", true) : chart.bbox.top + chart.bbox.height;
}

/** Of points that follow each other with an interval each. */
function runsOf(errors: (DrawnError | null)[]): number[][] {
  const runs: number[][] = [];
  errors.forEach((error, index) => {
    if (!error || error.least === error.greatest) return;
    if (runs.at(-1)?.at(-1) === index - 1) runs.at(-1)!.push(index);
    else runs.push([index]);
  });
  return runs;
}

/** Beneath the curves: for uPlot's drawAxes. */
export function drawBands(chart: uPlot, series: IntervalSeries[]): void {
  clipped(chart, (ctx, scale) => {
    const x = (index: number) => chart.valToPos(chart.data[0]![index]!, "x", true);
    for (const { colour, errors } of series)
      for (const run of runsOf(errors)) {
        ctx.fillStyle = ctx.strokeStyle = colour;
        ctx.lineWidth = kLine * scale;
        ctx.beginPath();
        if (run.length === 1) {
          ctx.moveTo(x(run[0]!), heightOf(chart, errors[run[0]!]!.greatest));
          ctx.lineTo(x(run[0]!), heightOf(chart, errors[run[0]!]!.least));
          ctx.stroke();
          continue;
        }
        for (const index of run) ctx.lineTo(x(index), heightOf(chart, errors[index]!.greatest));
        for (const index of [...run].reverse()) ctx.lineTo(x(index), heightOf(chart, errors[index]!.least));
        ctx.globalAlpha = kBandOpacity;
        ctx.fill();
        ctx.globalAlpha = 1;
      }
  });
}

/** Above the curves: for uPlot's draw. */
export function drawBounds(chart: uPlot, series: IntervalSeries[]): void {
  clipped(chart, (ctx, scale) => {
    for (const { colour, errors } of series)
      errors.forEach((error, index) => {
        if (!error?.isBound) return;
        const [x, y] = [chart.valToPos(chart.data[0]![index]!, "x", true), heightOf(chart, error.at)];
        const [stem, head, cap] = [kArrow.stem * scale, kArrow.head * scale, kArrow.cap * scale];
        ctx.strokeStyle = colour;
        ctx.lineWidth = kLine * scale;
        ctx.beginPath();
        ctx.moveTo(x - cap, y);
        ctx.lineTo(x + cap, y);
        ctx.moveTo(x, y);
        ctx.lineTo(x, y + stem);
        ctx.moveTo(x - head, y + stem - head);
        ctx.lineTo(x, y + stem);
        ctx.lineTo(x + head, y + stem - head);
        ctx.stroke();
      });
  });
}
