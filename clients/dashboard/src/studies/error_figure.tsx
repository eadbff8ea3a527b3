// Error against time with its legend, which switches entries, and what the curves say at the time one points at.

import { useEffect, useMemo, useRef, useState } from "preact/hooks";

import { isDark } from "../app/theme";
import { saveBlob } from "../api/client";
import { numberText, secondsText } from "../ui/format";
import { seriesLook, type SeriesLook } from "../ui/palette";
import { errorAt, idealSlope, type Series } from "./series";
import { svgFile } from "./svg_file";
import type { errorTimePlot } from "./plots";

const kPaperWidth = 760;
const kPaperHeight = 480;

const kShapes: Record<SeriesLook["symbol"], string> = {
  circle: "M4 0A4 4 0 1 1 -4 0A4 4 0 1 1 4 0Z",
  square: "M-3.5 -3.5H3.5V3.5H-3.5Z",
  triangle: "M0 -4.5L4 3.5H-4Z",
  diamond: "M0 -5L4 0L0 5L-4 0Z",
  cross: "M-4.5 -1.5H-1.5V-4.5H1.5V-1.5H4.5V1.5H1.5V4.5H-1.5V1.5H-4.5Z",
  star: "M0 -5L1.2 -1.6L4.8 -1.5L1.9 0.6L2.9 4L0 2L-2.9 4L-1.9 0.6L-4.8 -1.5L-1.2 -1.6Z",
};

/** The stroke and mark of a row, as the figures draw it. */
export function Swatch({ row }: { row: number }) {
  const { colour, dash, symbol } = seriesLook(row, isDark.value);
  return (
    <svg class="study-swatch" width="34" height="12" viewBox="-17 -6 34 12" aria-hidden="true">
      <line x1="-17" x2="17" y1="0" y2="0" stroke={colour} stroke-width="2" stroke-dasharray={dash.join(" ") || undefined} />
      <path d={kShapes[symbol]} fill={colour} />
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
  showFront: boolean;
}

type Drawn = NonNullable<ReturnType<typeof errorTimePlot>>;

export function ErrorFigure({ title, metric, series, hidden, onHidden, noise, showFront }: Props) {
  const [holder, width] = useWidth();
  const [drawn, setDrawn] = useState<Drawn | null>(null);
  const [failure, setFailure] = useState<string | null>(null);
  const [time, setTime] = useState<number | null>(null);
  const dark = isDark.value;
  const input = useMemo(
    () => ({ metric, series, hidden, noise, ideal: idealSlope(metric), showFront }),
    [metric, series, hidden, noise, showFront],
  );
  useEffect(() => {
    if (width === 0) return;
    let current = true;
    import("./plots").then(
      (plots) => {
        if (!current) return;
        const made = plots.errorTimePlot(input, { dark, width, height: Math.max(300, Math.min(520, Math.round(width * 0.55))) });
        holder.current!.replaceChildren(...(made ? [made] : []));
        setDrawn(made);
      },
      (reason: Error) => setFailure(reason.message),
    );
    return () => {
      current = false;
    };
  }, [input, dark, width]);

  const shown = series.filter((one) => !hidden.has(one.row) && one.points.length > 0);
  const times = useMemo(() => [...new Set(shown.flatMap((one) => one.points.map((point) => point.seconds)))].sort((a, b) => a - b), [series, hidden]);
  const moveTo = (event: PointerEvent) => {
    const x = drawn?.scale("x");
    if (!x?.invert) return;
    const box = drawn!.getBoundingClientRect();
    const at = x.invert(((event.clientX - box.left) * width) / box.width) as number;
    setTime(at >= times[0]! && at <= times.at(-1)! ? at : null);
  };
  const step = (event: KeyboardEvent) => {
    if (event.key !== "ArrowLeft" && event.key !== "ArrowRight") return;
    const back = event.key === "ArrowLeft";
    const next = back ? [...times].reverse().find((other) => other < (time ?? Infinity)) : times.find((other) => other > (time ?? 0));
    if (next !== undefined) setTime(next);
    event.preventDefault();
  };
  const save = async () => {
    const plots = await import("./plots");
    const paper = plots.errorTimePlot(input, { dark: false, width: kPaperWidth, height: kPaperHeight });
    if (!paper) return;
    const text = svgFile(paper, title, shown);
    saveBlob(new Blob([text], { type: "image/svg+xml" }), `${title.replace(/[^\w.-]+/g, "-")}.svg`);
  };
  const x = time !== null ? (drawn?.scale("x")?.apply(time) as number | undefined) : undefined;
  const readings = time === null ? [] : shown.map((one) => ({ ...one, error: errorAt(one.points, time) })).sort((a, b) => (a.error ?? Infinity) - (b.error ?? Infinity));
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
        <button class="study-save" onClick={() => void save()} disabled={!drawn}>
          Save SVG
        </button>
      </div>
      {failure && <p class="notice failed">The figure could not be loaded: {failure}</p>}
      <div
        class="study-plot-stage"
        tabIndex={0}
        role="group"
        aria-label={`${metric} against time. Left and right arrows read the curves.`}
        onPointerMove={moveTo}
        onPointerLeave={() => setTime(null)}
        onKeyDown={step}
      >
        <div ref={holder} class="study-plot-holder" />
        {x !== undefined && <div class="study-cursor" style={{ left: `${x}px` }} aria-hidden="true" />}
        {shown.length === 0 && <p class="empty">{series.every((one) => one.points.length === 0) ? "Nothing has been measured yet." : "Every entry is hidden."}</p>}
      </div>
      <p class="study-readout" aria-live="polite">
        {time === null ? (
          <span class="muted">Point at the figure, or step through it with the arrow keys, to read the curves.</span>
        ) : (
          <>
            <b>{secondsText(time)}</b>
            {readings.map((one) => (
              <span key={one.row} class="study-reading">
                <Swatch row={one.row} /> {one.name} {one.error === null ? "not measured" : numberText(one.error)}
              </span>
            ))}
          </>
        )}
      </p>
    </div>
  );
}
