// The tables of a comparison as figures: what the page shows, and what a spreadsheet or a paper is given.

import type { ComparisonRow } from "../api/types";
import { drawnError } from "../ui/error_interval";
import { numberText, secondsText } from "../ui/format";
import { rowName } from "./series";

export interface Cell {
  /** null where not every seed has one. An error of 0 or less is not told apart from 0. */
  value: number | null;
  low: number | null;
  high: number | null;
  /** What the reference's noise leaves open: least and greatest error, or from when to when; null where not known. */
  from: number | null;
  to: number | null;
  /** The value is an upper bound. */
  atMost: boolean;
  best: boolean;
  /** Over the best of the column; null for the best itself. */
  ratio: number | null;
  reached: number;
  seeds: number;
}

export interface FiguresTable {
  kind: "time_to_error" | "error_at_time";
  metric: string;
  /** Errors, falling, or seconds, rising. */
  columns: number[];
  rows: { row: number; name: string; cells: Cell[] }[];
}

type Figure = Pick<Cell, "value" | "from" | "to">;

const intervalOf = ({ from, to }: Figure): [number, number] | null => (from !== null && to !== null ? [from, to] : null);

/** The least figure of a column. One that is not told apart from 0 is the least only where all others are above its interval. */
function leastOf(cells: Figure[]): number {
  const known = cells.filter((cell) => cell.value !== null);
  const positive = Math.min(...known.map((cell) => (cell.value! > 0 ? cell.value! : Infinity)));
  const bounds = known.filter((cell) => !(cell.value! > 0));
  if (bounds.length === 0) return positive;
  const drawn = drawnError(bounds[0]!.value, intervalOf(bounds[0]!));
  return bounds.length === 1 && drawn && drawn.at < positive ? bounds[0]!.value! : NaN;
}

export function figuresTable(kind: FiguresTable["kind"], rows: ComparisonRow[], metric: string): FiguresTable {
  const cellsOf = (row: ComparisonRow): Omit<Cell, "best" | "ratio">[] =>
    kind === "time_to_error"
      ? (row.time_to_error[metric] ?? []).map((at) => ({
          ...at, value: at.seconds, from: at.earliest ?? null, to: at.latest ?? null, atMost: at.at_most, seeds: row.seeds,
        }))
      : (row.error_at_time[metric] ?? []).map((at) => ({
          ...at, value: at.error, from: at.interval?.[0] ?? null, to: at.interval?.[1] ?? null, atMost: false, seeds: row.seeds,
        }));
  const first = rows[0];
  const columns = !first
    ? []
    : kind === "time_to_error"
      ? (first.time_to_error[metric] ?? []).map((at) => at.error)
      : (first.error_at_time[metric] ?? []).map((at) => at.seconds);
  const cells = rows.map(cellsOf);
  const best = columns.map((_, c) => leastOf(cells.flatMap((row) => (row[c] ? [row[c]] : []))));
  return {
    kind,
    metric,
    columns,
    rows: rows.map((row, r) => ({
      row: r,
      name: rowName(row),
      cells: cells[r]!.map(({ value, low, high, from, to, atMost, reached, seeds }, c) => {
        const isBest = value !== null && value === best[c] && rows.length > 1;
        const ratio = value !== null && value > 0 && best[c]! > 0 && !isBest ? value / best[c]! : null;
        return { value, low, high, from, to, atMost, reached, seeds, best: isBest, ratio };
      }),
    })),
  };
}

export const columnText = (table: FiguresTable, column: number): string =>
  table.kind === "time_to_error" ? numberText(column) : secondsText(column);
export const cellText = (table: FiguresTable, value: number): string =>
  table.kind === "time_to_error" ? secondsText(value) : numberText(value);

/** What an error is below that is not told apart from 0; null of any other figure. */
export function boundOf(table: FiguresTable, cell: Cell): number | null {
  const drawn = table.kind === "error_at_time" ? drawnError(cell.value, intervalOf(cell)) : null;
  return drawn?.isBound ? drawn.at : null;
}

/** What the reference's noise leaves open: "0.001 to 0.002", "from 1.2 s" where nothing says until when; empty where it is not known, or no more than the figure. */
export function openText(table: FiguresTable, { from, to }: Cell): string {
  if (from !== null && to !== null) return cellText(table, from) === cellText(table, to) ? "" : `${cellText(table, from)} to ${cellText(table, to)}`;
  return from !== null ? `from ${cellText(table, from)}` : to !== null ? `until ${cellText(table, to)}` : "";
}

// -- text files ---------------------------------------------------------------------------------------------------------

type Field = string | number | boolean | null | undefined;

/** RFC 4180: what has a comma, a quote or a line's end is quoted. */
function csvField(field: Field): string {
  if (field === null || field === undefined) return "";
  const text = String(field);
  return /[",\r\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text;
}

export const csvOf = (lines: Field[][]): string => lines.map((line) => `${line.map(csvField).join(",")}\r\n`).join("");

/** A line for each figure, unrounded, so that whoever reads it need not take cells apart. */
export function figuresCsv(table: FiguresTable): string {
  const [given, asked] = table.kind === "time_to_error" ? ["error", "seconds"] : ["seconds", "error"];
  const lines: Field[][] = [["entry", "metric", given, asked, "low_95", "high_95", "at_most", "best", "ratio_to_best", "seeds_reached", "seeds", ...(table.kind === "time_to_error" ? ["earliest", "latest"] : ["least_90", "greatest_90"])]];
  for (const row of table.rows)
    row.cells.forEach((cell, c) =>
      lines.push([
        row.name, table.metric, table.columns[c], cell.value, cell.low, cell.high, cell.atMost, cell.best, cell.best ? 1 : cell.ratio,
        cell.reached, cell.seeds, cell.from, cell.to,
      ]),
    );
  return csvOf(lines);
}

const kLatex: Record<string, string> = {
  "\\": "\\textbackslash{}", "{": "\\{", "}": "\\}", "$": "\\$", "&": "\\&", "#": "\\#", "%": "\\%", "_": "\\_",
  "~": "\\textasciitilde{}", "^": "\\textasciicircum{}", "<": "\\textless{}", ">": "\\textgreater{}", "|": "\\textbar{}",
  '"': "\\textquotedbl{}", "µ": "\\textmu{}", "×": "\\texttimes{}", "–": "--", "−": "$-$", "∞": "$\\infty$", "≤": "$\\leq$",
};

/** Text as it may stand in LaTeX; all else than ASCII is left to its input encoding, UTF-8. */
export const escapeLatex = (text: string): string => text.replace(/[\\{}$&#%_~^<>|"µ×–−∞≤]/g, (char) => kLatex[char]!).replace(/\s+/g, " ");

/** 1.23 × 10^-5 in mathematics; plain digits where a person would write them. */
export function latexNumber(value: number): string {
  const text = numberText(value);
  const exponent = /^(.*)e(.*)$/.exec(text);
  return exponent ? `$${exponent[1]} \\cdot 10^{${exponent[2]!.replace("−", "-")}}$` : escapeLatex(text);
}

interface LatexText {
  caption: string;
  label: string;
}

/** A booktabs table, the best of each column in bold, intervals beneath their figures. */
export function figuresLatex(table: FiguresTable, text: LatexText): string {
  const timed = table.kind === "time_to_error";
  const figure = (cell: Cell): string => {
    if (cell.value === null) return "--";
    const bound = boundOf(table, cell);
    const written = (timed ? escapeLatex(secondsText(cell.value)) : latexNumber(bound ?? cell.value)).replace(/ (?=[^ ]+$)/, "~");
    return `${cell.atMost ? "$\\leq$~" : bound !== null ? "$<$~" : ""}${cell.best ? `\\textbf{${written}}` : written}`;
  };
  const end = (value: number): string => (timed ? escapeLatex(secondsText(value)) : latexNumber(value));
  // Over the seeds; of one seed what the reference's noise leaves open.
  const interval = (cell: Cell): string => {
    const [low, high] = cell.low !== null ? [cell.low, cell.high] : [cell.from, cell.to];
    return cell.value === null || low === null || high === null ? "" : `{\\footnotesize ${end(low)} to ${end(high)}}`;
  };
  const lines = [
    "% needs \\usepackage{booktabs} and \\usepackage{textcomp}",
    "\\begin{table}",
    "  \\centering",
    `  \\caption{${text.caption}}`,
    `  \\label{${text.label}}`,
    `  \\begin{tabular}{l${"r".repeat(table.columns.length)}}`,
    "    \\toprule",
    `    & \\multicolumn{${table.columns.length}}{c}{${timed ? `time to a ${escapeLatex(table.metric)} of` : `${escapeLatex(table.metric)} after`}} \\\\`,
    `    \\cmidrule(l){2-${table.columns.length + 1}}`,
    `    & ${table.columns.map((column) => (timed ? latexNumber(column) : escapeLatex(secondsText(column)))).join(" & ")} \\\\`,
    "    \\midrule",
  ];
  for (const row of table.rows) {
    lines.push(`    ${escapeLatex(row.name)} & ${row.cells.map(figure).join(" & ")} \\\\`);
    const intervals = row.cells.map(interval);
    if (intervals.some(Boolean)) lines.push(`    & ${intervals.join(" & ")} \\\\`);
  }
  lines.push("    \\bottomrule", "  \\end{tabular}", "\\end{table}", "");
  return lines.join("\n");
}
