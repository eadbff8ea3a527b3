import { describe, expect, it } from "vitest";

import type { ComparisonRow } from "../api/types";
import { boundOf, csvOf, escapeLatex, figuresCsv, figuresLatex, figuresTable, latexNumber, openText } from "./figures_table";

const row = (label: string, times: [number, number | null][], interval: [number, number] | null = null): ComparisonRow =>
  ({
    label,
    parameters: {},
    seeds: 2,
    time_to_error: {
      relative_mse: times.map(([error, seconds]) => ({
        error, seconds, reached: seconds === null ? 1 : 2, at_most: seconds === 0.05,
        low: seconds !== null && interval ? interval[0] : null, high: seconds !== null && interval ? interval[1] : null,
      })),
    },
    error_at_time: {},
  }) as unknown as ComparisonRow;

const rows = [row("a_1 & 100 %", [[0.1, 0.05], [0.01, 2], [0.001, null]], [1.9, 2.1]), row("b", [[0.1, 0.2], [0.01, 1], [0.001, null]])];
const table = figuresTable("time_to_error", rows, "relative_mse");

describe("figures", () => {
  it("mark the best of each column and say how far the others are", () => {
    expect(table.columns).toEqual([0.1, 0.01, 0.001]);
    expect(table.rows.map((one) => one.cells.map((cell) => cell.best))).toEqual([[true, false, false], [false, true, false]]);
    expect(table.rows[0]!.cells[1]!.ratio).toBe(2);
    expect(table.rows[1]!.cells[0]!.ratio).toBe(4);
    expect(table.rows[1]!.cells[2]).toMatchObject({ value: null, ratio: null, reached: 1, seeds: 2 });
  });
  it("have no best where there is one row", () => {
    expect(figuresTable("time_to_error", rows.slice(0, 1), "relative_mse").rows[0]!.cells.some((cell) => cell.best)).toBe(false);
  });
});

describe("figures that two films measured", () => {
  const timed = (values: [number | null, [number, number] | null][]) =>
    values.map(([error, interval], i) => ({
      label: `row ${i}`, parameters: {}, seeds: 1, time_to_error: {}, error_at_time: { relative_mse: [{ seconds: 2, error, low: null, high: null, reached: 1, interval }] },
    }) as unknown as ComparisonRow);
  const errors = (...values: [number | null, [number, number] | null][]) => figuresTable("error_at_time", timed(values), "relative_mse");

  it("say what the reference's noise leaves open", () => {
    const made = errors([0.002, [0.001, 0.003]], [-0.001, [-0.005, 0.004]]);
    const [first, second] = made.rows.map((one) => one.cells[0]!);
    expect([openText(made, first!), boundOf(made, first!)]).toEqual(["0.001 to 0.003", null]);
    expect([openText(made, second!), boundOf(made, second!)]).toEqual(["-0.005 to 0.004", 0.004]);
    expect(figuresCsv(made).trim().split("\r\n")[2]).toBe("row 1,relative_mse,2,-0.001,,,false,false,,1,1,-0.005,0.004");
    expect(figuresLatex(made, { caption: "", label: "" })).toContain("row 1 & $<$~0.004 \\\\\n    & {\\footnotesize -0.005 to 0.004}");
  });
  it("have a best only where it is told apart from the others", () => {
    const best = (...values: [number | null, [number, number] | null][]) => errors(...values).rows.map((one) => [one.cells[0]!.best, one.cells[0]!.ratio]);
    expect(best([0.002, [0.001, 0.003]], [0.004, [0.003, 0.005]])).toEqual([[true, null], [false, 2]]);
    expect(best([0.002, [0.001, 0.003]], [-0.001, [-0.005, 0.004]])).toEqual([[false, null], [false, null]]);
    expect(best([0.02, [0.01, 0.03]], [-0.001, [-0.005, 0.004]])).toEqual([[false, null], [true, null]]);
    expect(best([-0.002, [-0.01, 0.003]], [-0.001, [-0.005, 0.004]])).toEqual([[false, null], [false, null]]);
  });
  it("have times from when to when", () => {
    const at = { error: 0.1, seconds: 2, low: null, high: null, reached: 1, at_most: false };
    const made = figuresTable("time_to_error", [{ label: "a", parameters: {}, seeds: 1, time_to_error: { relative_mse: [{ ...at, earliest: 1, latest: 3 }, { ...at, earliest: 1, latest: null }, { ...at, earliest: 2, latest: 2 }, at] }, error_at_time: {} }] as unknown as ComparisonRow[], "relative_mse");
    expect(made.rows[0]!.cells.map((cell) => openText(made, cell))).toEqual(["1 s to 3 s", "from 1 s", "", ""]);
  });
});

describe("CSV", () => {
  it("quotes what must be quoted", () => {
    expect(csvOf([["a,b", 'say "x"', null, 1.5, true]])).toBe('"a,b","say ""x""",,1.5,true\r\n');
  });
  it("has a line a figure, unrounded", () => {
    const lines = figuresCsv(table).trim().split("\r\n");
    expect(lines).toHaveLength(7);
    expect(lines[2]).toBe("a_1 & 100 %,relative_mse,0.01,2,1.9,2.1,false,false,2,2,2,,");
    expect(lines[3]).toBe("a_1 & 100 %,relative_mse,0.001,,,,false,false,,1,2,,");
  });
});

describe("LaTeX", () => {
  it("escapes all that would be a command", () => {
    expect(escapeLatex("50 % of $x_1^2$ & {\\a} #1 ~ <b>\n")).toBe(
      "50 \\% of \\$x\\_1\\textasciicircum{}2\\$ \\& \\{\\textbackslash{}a\\} \\#1 \\textasciitilde{} \\textless{}b\\textgreater{} ",
    );
  });
  it("writes numbers as mathematics where they need an exponent", () => {
    expect([0.001, 0.0000123, 1234567].map(latexNumber)).toEqual(["0.001", "$1.23 \\cdot 10^{-5}$", "$1.23 \\cdot 10^{6}$"]);
  });
  it("is a whole booktabs table with the best in bold", () => {
    const text = figuresLatex(table, { caption: "Time", label: "tab:time" });
    expect(text).toContain("\\begin{tabular}{lrrr}");
    expect(text).toContain("& 0.1 & 0.01 & 0.001 \\\\");
    expect(text).toContain("a\\_1 \\& 100 \\% & $\\leq$~\\textbf{50~ms} & 2~s & -- \\\\");
    expect(text).toContain("{\\footnotesize 1.9 s to 2.1 s}");
    expect(text).toContain("b & 200~ms & \\textbf{1~s} & -- \\\\");
    // Every line of the body has as many columns as the head says.
    const body = text.split("\n").filter((line) => / & .*\\\\$/.test(line) && !line.includes("multicolumn"));
    for (const line of body) expect(line.replaceAll("\\&", "").split("&")).toHaveLength(4);
    expect((text.match(/\\begin/g) ?? []).length).toBe((text.match(/\\end/g) ?? []).length);
  });
});
