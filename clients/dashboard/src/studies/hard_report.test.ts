import { describe, expect, it } from "vitest";

import { biasText, hardCsv, hardLatex, NotAReport, onlyBreaking, readHardReport, type HardCheck } from "./hard_report";

const check: HardCheck = {
  relation: "equals", layer: "beauty", holds: false, text: "breaks", tolerance: 0.01, measured: [1, 1, 1], answer: [1, 1, 1], relative: true, bias: 0.0123, standard_error: 0.002,
  half_width: 0.01, worst_pixel: null,
};
const cell = (entry: string, verdict: string) => ({
  entry, verdict, text: verdict, reason: verdict === "not_applicable" ? "no glass, \"yet\"" : null, defects: [], notes: [], nan_count: 0, infinity_count: 0, negative_count: 0, seconds: 1,
  jobs: ["J1"], shown: verdict === "not_applicable" ? null : 0, checks: verdict === "not_applicable" ? [] : [check],
});
const report = {
  version: "0.1", form: "short", seconds: 2, seeds: 6, effort: 1, false_alarm: 1e-6, comparisons: 1, jobs: 4,
  summary: { holds: 1, breaks: 1, not_applicable: 1, defects: 0 },
  entries: [{ label: "a_b", method: {} }, { label: "c", method: {} }],
  cases: [
    { case: "x", name: "one & two", scene: "s", test: null, strains: "", text: "", cells: [cell("a_b", "breaks"), cell("c", "holds")] },
    { case: "y", name: "three", scene: "t", test: null, strains: "", text: "", cells: [cell("a_b", "not_applicable"), cell("c", "holds")] },
    { case: "z", name: "tested", scene: null, test: "unit", strains: "", text: "", cells: [] },
  ],
};
const read = () => readHardReport(JSON.stringify(report));

describe("a hard cases report", () => {
  it("is read", () => expect(read().cases).toHaveLength(3));
  it("is refused with what is wrong and where", () => {
    const refusal = (value: unknown) => {
      try {
        readHardReport(typeof value === "string" ? value : JSON.stringify(value));
      } catch (failure) {
        expect(failure).toBeInstanceOf(NotAReport);
        return (failure as Error).message;
      }
      throw new Error("was taken");
    };
    expect(refusal("{")).toContain("not JSON");
    expect(refusal([])).toContain("it is not an object");
    expect(refusal({})).toContain("/entries is not there");
    const odd = structuredClone(report);
    odd.cases[1]!.cells[0]!.verdict = "maybe";
    expect(refusal(odd)).toContain("/cases/1/cells/0/verdict is none of holds, breaks, not_applicable");
  });
  it("says bias with its error", () => {
    expect(biasText(check)).toBe("+1.23 % ± 0.2 %");
    expect(biasText({ ...check, relative: false, bias: -0.5 })).toBe("-0.5 ± 0.002");
    expect(biasText(null)).toBe("");
  });
  it("keeps to cases that break", () => expect(onlyBreaking(read()).map((row) => row.name)).toEqual(["one & two"]));
  it("is a table for a spreadsheet", () => {
    const lines = hardCsv(read()).trim().split("\r\n");
    expect(lines).toHaveLength(5);
    expect(lines[1]).toBe("one & two,a_b,breaks,breaks,,beauty equals,0.0123,0.002,0.01,true,0,0,0,1,J1");
    expect(lines[3]).toContain('"no glass, ""yet"""');
  });
  it("is a table for a paper", () => {
    const text = hardLatex(read());
    expect(text).toContain("case & a\\_b & c \\\\");
    expect(text).toContain("one \\& two & \\textbf{breaks} {\\footnotesize +1.23 \\% $\\pm$ 0.2 \\%} & holds");
    expect(text).toContain("three & n/a & holds");
    expect(text).not.toContain("tested");
  });
});
