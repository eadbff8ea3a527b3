// The tables of a comparison on the page, and the files that are saved of them.

import { useState } from "preact/hooks";

import { saveBlob } from "../api/client";
import type { ComparisonRow, FinalError } from "../api/types";
import { shortError } from "../ui/error_interval";
import { bytesText, countText, kNone, numberText, secondsText } from "../ui/format";
import { say, sayFailure } from "../ui/toasts";
import { Swatch } from "./error_figure";
import { boundOf, cellText, columnText, csvOf, escapeLatex, figuresCsv, figuresLatex, openText, type Cell, type FiguresTable } from "./figures_table";
import { rowName } from "./series";

export function saveText(text: string, type: string, name: string): void {
  saveBlob(new Blob([text], { type: `${type};charset=utf-8` }), name);
}

function CellView({ table, cell }: { table: FiguresTable; cell: Cell | undefined }) {
  if (!cell || cell.value === null)
    return (
      <td class="number muted" title={cell ? `${cell.reached} of ${cell.seeds} seeds` : undefined}>
        {kNone}
        {cell && cell.reached > 0 && <small>{`${cell.reached} of ${cell.seeds} seeds`}</small>}
      </td>
    );
  const bound = boundOf(table, cell);
  const open = openText(table, cell);
  return (
    <td class={cell.best ? "number study-best" : "number"}>
      {cell.best && (
        <span class="study-mark" title="the best">
          ★<span class="visually-hidden">best: </span>
        </span>
      )}
      {cell.atMost && <span title="there at its first measurement">≤ </span>}
      {bound !== null ? <span title="not told apart from 0">below {numberText(bound)}</span> : cellText(table, cell.value)}
      {cell.ratio !== null && <small>× {numberText(cell.ratio)}</small>}
      {cell.low !== null && cell.high !== null && (
        <small>
          {cellText(table, cell.low)} – {cellText(table, cell.high)}
        </small>
      )}
      {open && <small>({open})</small>}
    </td>
  );
}

interface FiguresProps {
  table: FiguresTable;
  /** For file names: "C1". */
  study: string;
  scene: string;
}

export function FiguresView({ table, study, scene }: FiguresProps) {
  const [latex, setLatex] = useState<string | null>(null);
  const timed = table.kind === "time_to_error";
  const name = timed ? `Time to reach ${table.metric}` : `${table.metric} after a time`;
  if (table.columns.length === 0) return <p class="empty">Nothing has been measured yet.</p>;
  const makeLatex = () =>
    figuresLatex(table, {
      caption: `${timed ? `Time until the ${escapeLatex(table.metric)} stays below a value` : `${escapeLatex(table.metric)} after a time`}; ${escapeLatex(scene)}.`,
      label: `tab:${study.toLowerCase()}-${table.kind.replaceAll("_", "-")}`,
    });
  return (
    <div class="stack study-tight">
      <div class="scroll-x" tabIndex={0} role="group" aria-label={name}>
        <table class="study-table">
          <thead>
            <tr>
              <th scope="col">Entry</th>
              {table.columns.map((column) => (
                <th key={column} class="number" scope="col">
                  {columnText(table, column)}
                </th>
              ))}
            </tr>
          </thead>
          <tbody>
            {table.rows.map((row) => (
              <tr key={row.row}>
                <th scope="row">
                  <Swatch row={row.row} /> {row.name}
                </th>
                {table.columns.map((column, c) => (
                  <CellView key={column} table={table} cell={row.cells[c]} />
                ))}
              </tr>
            ))}
          </tbody>
        </table>
      </div>
      <div class="row">
        <span class="muted small study-fill">
          ★ the best of its column; × over the best
          {table.rows.some((row) => row.cells.some((cell) => cell.low !== null)) && "; small: 95 % interval over the seeds"}
          {table.rows.some((row) => row.cells.some((cell) => cell.from !== null || cell.to !== null)) && "; in brackets: what the reference's noise leaves open, at 90 %"}
          {timed ? "; ≤ there at the first measurement; – not reached by every seed" : "; – outside some seed's curve"}
        </span>
        <button onClick={() => saveText(figuresCsv(table), "text/csv", `${study}-${table.kind}.csv`)}>CSV</button>
        <button aria-expanded={latex !== null} onClick={() => setLatex(latex === null ? makeLatex() : null)}>
          LaTeX
        </button>
      </div>
      {latex !== null && (
        <div class="stack study-tight">
          <pre class="study-code" tabIndex={0} aria-label="LaTeX table">
            {latex}
          </pre>
          <div class="row">
            <button onClick={() => navigator.clipboard.writeText(latex).then(() => say("Copied."), sayFailure)}>Copy</button>
            <button onClick={() => saveText(latex, "application/x-tex", `${study}-${table.kind}.tex`)}>Save .tex</button>
          </div>
        </div>
      )}
    </div>
  );
}

const spreadText = (spread: { min: number; max: number } | null, text: (value: number) => string): string =>
  !spread ? kNone : spread.min === spread.max ? text(spread.min) : `${text(spread.min)} – ${text(spread.max)}`;

/** Why an error says little. */
const nearText = ({ value, interval }: FinalError): string =>
  !interval ? "near the reference's own noise" : (value ?? 0) > 0 ? "not known to a third of itself" : "not told apart from 0";

interface CostProps {
  rows: ComparisonRow[];
  metrics: string[];
  /** Rows on the front of time, memory and error. */
  withMemory: number[];
  study: string;
}

/** What each row took and came to. */
export function CostTable({ rows, metrics, withMemory, study }: CostProps) {
  const photons = rows.some((row) => row.photons);
  const save = () =>
    saveText(
      csvOf([
        ["entry", "seeds", "succeeded", "passes_min", "passes_max", "photons_min", "photons_max", "seconds_min", "seconds_max", ...metrics, "peak_bytes", "efficiency", "pareto_time_error", "pareto_time_memory_error",
          ...metrics.flatMap((metric) => [`${metric}_least_90`, `${metric}_greatest_90`]),
        ],
        ...rows.map((row, r) => [
          rowName(row), row.seeds, row.succeeded, row.passes?.min, row.passes?.max, row.photons?.min, row.photons?.max, row.seconds?.min, row.seconds?.max,
          ...metrics.map((metric) => row.error[metric]?.value), row.peak_bytes, row.efficiency, row.pareto, withMemory.includes(r), ...metrics.flatMap((metric) => row.error[metric]?.interval ?? [null, null]),
        ]),
      ]),
      "text/csv",
      `${study}-cost.csv`,
    );
  return (
    <div class="stack study-tight">
      <div class="scroll-x" tabIndex={0} role="group" aria-label="What it cost">
        <table class="study-table">
          <thead>
            <tr>
              <th scope="col">Entry</th>
              <th scope="col" class="number">Seeds</th>
              <th scope="col" class="number">Passes</th>
              {photons && <th scope="col" class="number">Photons</th>}
              <th scope="col" class="number">Time</th>
              {metrics.map((metric) => (
                <th key={metric} scope="col" class="number">
                  {metric}
                </th>
              ))}
              <th scope="col" class="number">Peak memory</th>
              <th scope="col" class="number" title="1 / (mean squared error × seconds)">Efficiency</th>
              <th scope="col" title="At some time no other entry has a lower error">Front: time, error</th>
              <th scope="col" title="At some time no other entry with as little memory has an error as low">… and memory</th>
            </tr>
          </thead>
          <tbody>
            {rows.map((row, r) => (
              <tr key={r}>
                <th scope="row">
                  <Swatch row={r} /> {rowName(row)}
                </th>
                <td class="number">{row.succeeded === row.seeds ? row.seeds : `${row.succeeded} of ${row.seeds}`}</td>
                <td class="number">{spreadText(row.passes, countText)}</td>
                {photons && <td class="number">{spreadText(row.photons, countText)}</td>}
                <td class="number">{spreadText(row.seconds, secondsText)}</td>
                {metrics.map((metric) => {
                  const error = row.error[metric];
                  return (
                    <td key={metric} class="number">
                      {shortError(error?.value, error?.interval)}
                      {error?.near_reference && <small class="study-warning">{nearText(error)}</small>}
                      {error?.value && error.low !== null && error.high !== null && (
                        <small>
                          {numberText(error.low)} – {numberText(error.high)}
                        </small>
                      )}
                      {error?.interval && (
                        <small>
                          ({numberText(error.interval[0])} to {numberText(error.interval[1])})
                        </small>
                      )}
                    </td>
                  );
                })}
                <td class="number">{bytesText(row.peak_bytes)}</td>
                <td class="number">{numberText(row.efficiency)}</td>
                <td>{row.pareto ? "★ yes" : "no"}</td>
                <td>{withMemory.includes(r) ? "★ yes" : row.peak_bytes === null ? "memory not known" : "no"}</td>
              </tr>
            ))}
          </tbody>
        </table>
      </div>
      <div class="row">
        <span class="muted small study-fill">
          At the end of each job{metrics.some((metric) => rows.some((row) => row.error[metric]?.interval)) && "; in brackets what the reference's noise leaves open, at 90 %"}. Memory: the largest seed's, beside the idle process. Efficiency: 1 / (mean squared error × seconds).
        </span>
        <button onClick={save}>CSV</button>
      </div>
    </div>
  );
}
