// What entries came to for their memory, and who is worth choosing: the Pareto front drawn and listed.

import { useEffect, useMemo } from "preact/hooks";

import { saveBlob } from "../api/client";
import type { ComparisonRow } from "../api/types";
import { isDark } from "../app/theme";
import { bytesText, numberText, secondsText } from "../ui/format";
import { Swatch, useWidth } from "./error_figure";
import { memoryFront, memoryPoints } from "./memory";
import { memoryPlot } from "./plots";
import { bestByTime, type Series } from "./series";
import { svgFile } from "./svg_file";

const kPaper = { dark: false, width: 560, height: 380 };

interface Props {
  title: string;
  metric: string;
  rows: ComparisonRow[];
  hidden: ReadonlySet<number>;
}

export function MemoryFigure({ title, metric, rows, hidden }: Props) {
  const [holder, width] = useWidth();
  const points = useMemo(() => memoryPoints(rows, metric, hidden), [rows, metric, hidden]);
  const front = memoryFront(points);
  const dark = isDark.value;
  useEffect(() => {
    if (width === 0) return;
    const made = memoryPlot(metric, points, { dark, width, height: 320 });
    holder.current!.replaceChildren(...(made ? [made.svg] : []));
  }, [points, metric, dark, width]);
  const save = () => {
    const paper = memoryPlot(metric, points, kPaper);
    if (!paper) return;
    saveBlob(new Blob([svgFile(paper.svg, title, [])], { type: "image/svg+xml" }), `${title.replace(/[^\w.-]+/g, "-")}.svg`);
  };
  return (
    <div class="study-figure">
      <div class="study-plot-stage" role="img" aria-label={`${metric} at the end against peak memory`}>
        <div ref={holder} class="study-plot-holder" />
        {points.length === 0 && <p class="empty">No entry has ended yet whose memory is known.</p>}
      </div>
      {points.length > 0 && (
        <div class="row">
          <span class="muted small study-fill">
            On the front of memory and error:{" "}
            {front.map((point) => `${point.name} (${bytesText(point.bytes)}, ${point.isBound ? "below " : ""}${numberText(point.error)})`).join("; ")}.
          </span>
          <button onClick={save}>Save SVG</button>
        </div>
      )}
    </div>
  );
}

/** Who is lowest when. */
export function BestByTime({ series, withMemory }: { series: Series[]; withMemory: number[] }) {
  const stretches = bestByTime(series);
  if (stretches.length === 0) return <p class="empty">Nothing has been measured yet.</p>;
  const name = (row: number) => series.find((one) => one.row === row)!.name;
  return (
    <>
      <ul class="study-fronts">
        {stretches.map((stretch, i) => (
          <li key={stretch.from}>
            <Swatch row={stretch.row} />{" "}
            {stretches.length === 1 ? "from first to last: " : i === 0 ? `until ${secondsText(stretch.to)}: ` : i === stretches.length - 1 ? `from ${secondsText(stretch.from)} on: ` : `${secondsText(stretch.from)} to ${secondsText(stretch.to)}: `}
            <b>{name(stretch.row)}</b>
          </li>
        ))}
      </ul>
      <p class="muted small">
        The lowest mean curve at each time: the Pareto front of time and error.{" "}
        {series.some((one) => one.points.some((point) => point.isBound)) && "Where a curve is not told apart from 0, its upper bound counts. "}
        {withMemory.length > 0 && `With memory as a third cost, worth choosing: ${withMemory.map(name).join(", ")}.`}
      </p>
    </>
  );
}
