// The list itself: a grid of which only the rows in view are there, moved in by keys or by scrolling.

import "./job_grid.css";

import { useSignalEffect } from "@preact/signals";
import { useCallback, useEffect, useLayoutEffect, useRef, useState } from "preact/hooks";

import type { JobSummary } from "../api/types";
import type { JobList } from "./job_list";
import { JobRow, kColumns } from "./row";
import { isSelected, type Selection } from "./selection";
import { scrollIntoView, scrollTopOf, windowOf } from "./window";

const kRowHeight = 36;
const kNarrowRowHeight = 84;

export interface GridControl {
  focus: () => void;
  /** Brings a row into view. */
  show: (place: number) => void;
  toTop: () => void;
  /** Rows a page key moves by. */
  pageRows: () => number;
  scrollTop: () => number;
}

interface Props {
  list: JobList;
  selection: Selection;
  active: number;
  /** Jobs came or went, so that all places are others by that; `above` what is read, and not seen. */
  onShift: (by: number, above: boolean) => void;
  onTop: () => void;
  onPoint: (place: number) => void;
  onPick: (place: number, range: boolean) => void;
  onPickAll: () => void;
  control: { current: GridControl | null };
  startAt: number;
}

const narrow = matchMedia("(max-width: 60rem)");

function useNarrow(): boolean {
  const [value, setValue] = useState(narrow.matches);
  useEffect(() => {
    const change = () => setValue(narrow.matches);
    narrow.addEventListener("change", change);
    return () => narrow.removeEventListener("change", change);
  }, []);
  return value;
}

export function JobGrid({ list, selection, active, onShift, onTop, onPoint, onPick, onPickAll, control, startAt }: Props) {
  const grid = useRef<HTMLDivElement>(null);
  const head = useRef<HTMLDivElement>(null);
  const [scroll, setScroll] = useState({ top: 0, height: 600 });
  const [, setVersion] = useState(0);
  const shifted = useRef(list.shifted);
  const isNarrow = useNarrow();
  const rowHeight = isNarrow ? kNarrowRowHeight : kRowHeight;
  const total = list.total ?? 0;
  const window = windowOf(total, rowHeight, scroll.top, scroll.height);

  // One drawing a frame, however many events came.
  const frame = useRef(0);
  useSignalEffect(() => {
    void list.version.value;
    frame.current ||= requestAnimationFrame(() => {
      frame.current = 0;
      setVersion(list.version.peek());
    });
  });
  useEffect(() => () => cancelAnimationFrame(frame.current), []);

  const measure = useCallback(() => {
    const element = grid.current!;
    const height = element.clientHeight - head.current!.offsetHeight;
    if (element.scrollTop <= 0) onTop();
    setScroll((old) => (old.top === element.scrollTop && old.height === height ? old : { top: element.scrollTop, height }));
  }, []);
  useLayoutEffect(() => {
    measure();
    const watcher = new ResizeObserver(measure);
    watcher.observe(grid.current!);
    return () => watcher.disconnect();
  }, []);
  useEffect(() => list.look(window.first, window.last), [list, window.first, window.last]);

  // The list began where it was left, as soon as there are rows to scroll over.
  const started = useRef(startAt === 0);
  useLayoutEffect(() => {
    if (started.current || list.total === null) return;
    started.current = true;
    grid.current!.scrollTop = startAt;
    measure();
  }, [list.total]);

  // Jobs came or went above: what is read stays where it is, unless one reads the newest.
  useLayoutEffect(() => {
    const delta = list.shifted - shifted.current;
    if (delta === 0) return;
    shifted.current = list.shifted;
    const above = grid.current!.scrollTop > 0;
    if (above) grid.current!.scrollTop += scrollTopOf(delta, total, rowHeight, scroll.height);
    onShift(delta, above);
    measure();
  });

  control.current = {
    focus: () => grid.current?.focus({ preventScroll: true }),
    show: (place) => {
      const to = scrollIntoView(place, list.total ?? 0, rowHeight, grid.current!.scrollTop, scroll.height);
      if (to !== null) grid.current!.scrollTop = to;
    },
    toTop: () => (grid.current!.scrollTop = 0),
    pageRows: () => Math.max(1, Math.floor(scroll.height / rowHeight) - 1),
    scrollTop: () => grid.current?.scrollTop ?? 0,
  };

  const rows: { place: number; job: JobSummary | undefined }[] = [];
  for (let place = window.first; place <= window.last; ++place) rows.push({ place, job: list.row(place) });
  return (
    <div
      ref={grid}
      class={`jobs-grid${isNarrow ? " narrow" : ""}`}
      role="grid"
      aria-label="Jobs, newest first"
      aria-rowcount={total + 1}
      aria-colcount={kColumns.length}
      aria-multiselectable="true"
      aria-activedescendant={active >= window.first && active <= window.last ? `jobs-row-${active}` : undefined}
      aria-busy={list.total === null}
      tabIndex={0}
      onScroll={measure}
    >
      <div ref={head} role="row" class="jobs-row jobs-head" aria-rowindex={1}>
        {kColumns.map(({ name, title, number }, index) => (
          <span key={name} role="columnheader" aria-colindex={index + 1} class={`jobs-cell jobs-${name}${number ? " number" : ""}`}>
            {name === "pick" ? (
              <label class="jobs-box">
                <input
                  type="checkbox"
                  tabIndex={-1}
                  checked={selection.all}
                  disabled={total === 0}
                  aria-label="Select all that match"
                  onClick={onPickAll}
                />
              </label>
            ) : (
              title
            )}
          </span>
        ))}
      </div>
      <div role="rowgroup" class="jobs-space" style={{ height: `${window.height}px` }}>
        {rows.map(({ place, job }) => (
          <JobRow
            key={place}
            job={job}
            place={place}
            top={window.offset + (place - window.first) * rowHeight}
            height={rowHeight}
            selected={isSelected(selection, job)}
            active={place === active}
            onPick={onPick}
            onPoint={onPoint}
          />
        ))}
      </div>
    </div>
  );
}
