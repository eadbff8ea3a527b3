// The report of `photonctl hard-cases --json-report`: read with care, for it comes from a file, and what is shown of it.

import { numberText } from "../ui/format";
import { csvOf, escapeLatex } from "./figures_table";

export type HardVerdict = "holds" | "breaks" | "not_applicable";

export interface HardCheck {
  relation: string;
  layer: string;
  holds: boolean;
  text: string;
  tolerance: number;
  measured: number[] | null;
  answer: number[] | null;
  relative: boolean | null;
  bias: number | null;
  standard_error: number | null;
  half_width: number | null;
  worst_pixel: { x: number; y: number; deviation: number } | null;
}

export interface HardCell {
  entry: string;
  verdict: HardVerdict;
  text: string;
  reason: string | null;
  defects: string[];
  notes: string[];
  nan_count: number;
  infinity_count: number;
  negative_count: number;
  seconds: number;
  jobs: string[];
  shown: number | null;
  checks: HardCheck[];
}

export interface HardCaseRow {
  case: string;
  name: string;
  scene: string | null;
  test: string | null;
  strains: string | string[];
  text: string;
  cells: HardCell[];
}

export interface HardReport {
  version: string;
  form: string;
  seconds: number;
  seeds: number;
  effort: number;
  false_alarm: number;
  comparisons: number;
  jobs: number;
  summary: { holds: number; breaks: number; not_applicable: number; defects: number };
  entries: { label: string; method: unknown }[];
  cases: HardCaseRow[];
}

export class NotAReport extends Error {}

const isObject = (value: unknown): value is Record<string, unknown> => typeof value === "object" && value !== null && !Array.isArray(value);
const kVerdicts: readonly string[] = ["holds", "breaks", "not_applicable"];

/** What a file says, or what of it is not as such a report is. */
export function readHardReport(text: string): HardReport {
  let value: unknown;
  try {
    value = JSON.parse(text);
  } catch (failure) {
    throw new NotAReport(`it is not JSON: ${(failure as Error).message}`);
  }
  const must = (holds: boolean, where: string, what: string) => {
    if (!holds) throw new NotAReport(`${where} ${what}; is it a report of photonctl hard-cases --json-report?`);
  };
  must(isObject(value), "it", "is not an object");
  const report = value as Record<string, unknown>;
  must(Array.isArray(report.entries), "/entries", "is not there");
  must(Array.isArray(report.cases), "/cases", "is not there");
  must(isObject(report.summary), "/summary", "is not there");
  (report.entries as unknown[]).forEach((entry, i) => must(isObject(entry) && typeof entry.label === "string", `/entries/${i}/label`, "is no text"));
  (report.cases as unknown[]).forEach((row, i) => {
    must(isObject(row) && typeof row.name === "string" && Array.isArray(row.cells), `/cases/${i}`, "has no name or no cells");
    ((row as Record<string, unknown>).cells as unknown[]).forEach((cell, j) => {
      const at = `/cases/${i}/cells/${j}`;
      must(isObject(cell) && typeof cell.verdict === "string" && kVerdicts.includes(cell.verdict), `${at}/verdict`, `is none of ${kVerdicts.join(", ")}`);
      for (const list of ["checks", "jobs", "defects", "notes"]) must(Array.isArray((cell as Record<string, unknown>)[list]), `${at}/${list}`, "is no list");
    });
  });
  return value as HardReport;
}

export const kVerdictWords: Record<HardVerdict, string> = { holds: "holds", breaks: "breaks", not_applicable: "not applicable" };
export const kVerdictMarks: Record<HardVerdict, string> = { holds: "✓", breaks: "✕", not_applicable: "–" };

export const shownCheck = (cell: HardCell): HardCheck | null => (cell.shown === null ? null : (cell.checks[cell.shown] ?? null));

const signed = (text: string, value: number): string => (value > 0 ? `+${text}` : text);
const amount = (check: HardCheck, value: number): string => (check.relative === false ? numberText(value) : `${numberText(100 * value)} %`);

/** "+1.2 % ± 0.3 %": the bias and its standard error; empty where nothing has such. */
export function biasText(check: HardCheck | null): string {
  if (!check || check.bias === null || check.standard_error === null) return "";
  return `${signed(amount(check, check.bias), check.bias)} ± ${amount(check, check.standard_error)}`;
}

export const mayBeText = (check: HardCheck): string => (check.half_width === null ? "" : `± ${amount(check, check.half_width)}`);

/** Rows with a cell that breaks; their other cells stay for the context. */
export const onlyBreaking = (report: HardReport): HardCaseRow[] => report.cases.filter((row) => row.cells.some((cell) => cell.verdict === "breaks"));

export function hardCsv(report: HardReport): string {
  const lines: (string | number | boolean | null | undefined)[][] = [
    ["case", "entry", "verdict", "text", "reason", "check", "bias", "standard_error", "half_width", "relative", "nan", "infinite", "negative", "seconds", "jobs"],
  ];
  for (const row of report.cases)
    for (const cell of row.cells) {
      const check = shownCheck(cell);
      lines.push([
        row.name, cell.entry, kVerdictWords[cell.verdict], cell.text, cell.reason, check ? `${check.layer} ${check.relation}` : "",
        check?.bias, check?.standard_error, check?.half_width, check?.relative, cell.nan_count, cell.infinity_count, cell.negative_count,
        cell.seconds, cell.jobs.join(" "),
      ]);
    }
  return csvOf(lines);
}

const kLatexMarks: Record<HardVerdict, string> = { holds: "holds", breaks: "\\textbf{breaks}", not_applicable: "n/a" };

/** Cases down, methods across; the bias where there is one. */
export function hardLatex(report: HardReport): string {
  const cell = (one: HardCell | undefined): string => {
    if (!one) return "--";
    const bias = biasText(shownCheck(one));
    const written = bias ? ` {\\footnotesize ${escapeLatex(bias).replace("±", "$\\pm$")}}` : "";
    return kLatexMarks[one.verdict] + (one.verdict === "not_applicable" ? "" : written);
  };
  const lines = [
    "% needs \\usepackage{booktabs} and \\usepackage{textcomp}",
    "\\begin{table}",
    "  \\centering",
    `  \\caption{Hard cases: bias and its standard error over ${report.seeds} seeds.}`,
    "  \\label{tab:hard-cases}",
    `  \\begin{tabular}{l${"l".repeat(report.entries.length)}}`,
    "    \\toprule",
    `    case & ${report.entries.map((entry) => escapeLatex(entry.label)).join(" & ")} \\\\`,
    "    \\midrule",
    ...report.cases
      .filter((row) => row.cells.length > 0)
      .map((row) => `    ${escapeLatex(row.name)} & ${report.entries.map((entry) => cell(row.cells.find((one) => one.entry === entry.label))).join(" & ")} \\\\`),
    "    \\bottomrule",
    "  \\end{tabular}",
    "\\end{table}",
    "",
  ];
  return lines.join("\n");
}
