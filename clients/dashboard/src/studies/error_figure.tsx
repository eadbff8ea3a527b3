// Error against time with its legend, which switches entries, and what the curves say at the time one points at.

import { useEffect, useMemo, useRef, useState } from "preact/hooks";

import { isDark } from "../app/theme";
import { saveBlob } from "../api/client";
import { ByPointer } from "../ui/by_pointer";
import { numberText, secondsText } from "../ui/format";
import { seriesLook } from "../ui/palette";
import type { Floor } from "./bias";
import type { LogFigure } from "./log_figure";
import { errorTimePlot } from "./plots";
import { idealSlope, readingAt, type Series } from "./series";
import { svgFile } from "./svg_file";
import { kSymbols } from "./symbols";

const kPaperWidth = 760;
const kPaperHeight = 480;

/** The stroke and mark of a row, as the figures draw it. */
export function Swatch({ row }: { row: number }) {
  const { colour, dash, symbol } = seriesLook(row, isDark.value);
  return (
    <svg class="study-swatch" width="34" height="12" viewBox="-17 -6 34 12" aria-hidden="true">
      <line x1="-17" x2="17" y1="0" y2="0" stroke={colour} stroke-width="2" stroke-dasharray={dash.join(" ") || undefined} />
      <path d={kSymbols[symbol]} fill={colour} />
    </svg>
  );
}

/** A figure of plots.ts in an element as wide as there is room, drawn anew when that or the theme changes. */
export function useWidth(): [{ current: HTMLDivElement | null }, number] {
  const holder = useRef<HTMLDivElement>(null);
  const [width, setWidth] = useState(0);
  useEffect(() => {
    const watcher = new ResizeObserver(([entry]) => setWidth(Math.floor(entry!.contentRect.width)));
    watcher.observe(holder.current!);
    return () => watcher.disconnect();
  }, []);
  return [holder, width];
}

interface Props {
  title: string;
  metric: string;
  series: Series[];
  hidden: ReadonlySet<number>;
  onHidden: (hidden: Set<number>) => void;
  noise: number | null;
  floors: Floor[];
  showFront: boolean;
}

export function ErrorFigure({ title, metric, series, hidden, onHidden, noise, floors, showFront }: Props) {
  const [holder, width] = useWidth();
  const [drawn, setDrawn] = useState<LogFigure | null>(null);
  const [time, setTime] = useState<number | null>(null);
  const dark = isDark.value;
  const input = useMemo(
    () => ({ metric, series, hidden, noise, floors, ideal: idealSlope(metric), showFront }),
    [metric, series, hidden, noise, floors, showFront],
  );
  useEffect(() => {
    if (width === 0) return;
    const made = errorTimePlot(input, { dark, width, height: Math.max(300, Math.min(520, Math.round(width * 0.55))) });
    holder.current!.replaceChildren(...(made ? [made.svg] : []));
    setDrawn(made);
  }, [input, dark, width]);

  const shown = series.filter((one) => !hidden.has(one.row) && one.points.length > 0);
  const times = useMemo(() => [...new Set(shown.flatMap((one) => one.points.map((point) => point.seconds)))].sort((a, b) => a - b), [series, hidden]);
  const moveTo = (event: PointerEvent) => {
    if (!drawn) return;
    const box = drawn.svg.getBoundingClientRect();
    const at = drawn.x.valueAt(((event.clientX - box.left) * width) / box.width);
    setTime(at >= times[0]! && at <= times.at(-1)! ? at : null);
  };
  const step = (event: KeyboardEvent) => {
    if (event.key !== "ArrowLeft" && event.key !== "ArrowRight") return;
    const back = event.key === "ArrowLeft";
    const next = back ? [...times].reverse().find((other) => other < (time ?? Infinity)) : times.find((other) => other > (time ?? 0));
    if (next !== undefined) setTime(next);
    event.preventDefault();
  };
  const save = () => {
    const paper = errorTimePlot(input, { dark: false, width: kPaperWidth, height: kPaperHeight });
    if (!paper) return;
    const text = svgFile(paper.svg, title, shown);
    saveBlob(new Blob([text], { type: "image/svg+xml" }), `${title.replace(/[^\w.-]+/g, "-")}.svg`);
  };
  const x = time !== null ? drawn?.x.at(time) : undefined;
  const readings = time === null ? [] : shown.map((one) => ({ ...one, at: readingAt(one.points, time) })).sort((a, b) => (a.at?.error ?? Infinity) - (b.at?.error ?? Infinity));
  return (
    <div class="study-figure">
      <div class="row study-legend" role="group" aria-label="Entries shown">
        {series.map((one) => (
          <button
            key={one.row}
            class="study-entry"
            aria-pressed={!hidden.has(one.row)}
            title={hidden.has(one.row) ? "Show it" : "Hide it"}
            onClick={() => {
              const next = new Set(hidden);
              if (!next.delete(one.row)) next.add(one.row);
              onHidden(next);
            }}
          >
            <Swatch row={one.row} />
            <span>{one.name}</span>
            {one.slope !== null && <span class="muted small">slope {numberText(one.slope, 2)}</span>}
          </button>
        ))}
        <button class="study-save" onClick={save} disabled={!drawn}>
          Save SVG
        </button>
      </div>
      <div
        class="study-plot-stage"
        tabIndex={0}
        role="group"
        aria-label={`${metric} against time. Left and right arrows read the curves.`}
        onPointerDown={moveTo}
        onPointerMove={moveTo}
        onPointerLeave={(event) => event.pointerType === "mouse" && setTime(null)} // a finger's reading stays when it is lifted
        onKeyDown={step}
      >
        <div ref={holder} class="study-plot-holder" />
        {x !== undefined && <div class="study-cursor" style={{ left: `${x}px` }} aria-hidden="true" />}
        {shown.length === 0 && <p class="empty">{series.every((one) => one.points.length === 0) ? "Nothing has been measured yet." : "Every entry is hidden."}</p>}
      </div>
      <p class="study-readout" aria-live="polite">
        {time === null ? (
          <span class="muted">
            <ByPointer mouse="Point at the figure, or step through it with the arrow keys, to read the curves." finger="Touch the figure to read the curves." />
          </span>
        ) : (
          <>
            <b>{secondsText(time)}</b>
            {readings.map((one) => (
              <span key={one.row} class="study-reading">
                <Swatch row={one.row} /> {one.name} {one.at === null ? "not measured" : `${one.at.isBound ? "below " : ""}${numberText(one.at.error)}`}
              </span>
            ))}
          </>
        )}
      </p>
    </div>
  );
}
