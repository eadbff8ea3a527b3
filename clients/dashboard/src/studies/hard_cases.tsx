// The table of hard cases: which method keeps to the known answer where. It is measured by photonctl and opened here.

import "./hard_cases.css";

import { useEffect, useRef, useState } from "preact/hooks";

import { Title } from "../app/title";
import { useQuery } from "../app/url_state";
import { countText, plainName, secondsText } from "../ui/format";
import { say, sayFailure } from "../ui/toasts";
import {
  biasText,
  hardCsv,
  hardLatex,
  kVerdictMarks,
  kVerdictWords,
  mayBeText,
  onlyBreaking,
  readHardReport,
  shownCheck,
  type HardCaseRow,
  type HardCell,
  type HardReport,
} from "./hard_report";
import { saveText } from "./tables_view";

const kStored = "photond.hard-cases";
const kCommand = "photonctl hard-cases --short --json-report hard-cases.json";

interface Opened {
  name: string;
  report: HardReport;
}

/** The last report that was opened, kept across reloads where there is room for it. */
function useReport(): [Opened | null, (file: File) => Promise<void>, () => void, string | null] {
  const [failure, setFailure] = useState<string | null>(null);
  const [opened, setOpened] = useState<Opened | null>(() => {
    try {
      const stored = JSON.parse(localStorage.getItem(kStored) ?? "null") as { name: string; text: string } | null;
      return stored && { name: stored.name, report: readHardReport(stored.text) };
    } catch {
      return null;
    }
  });
  const open = async (file: File) => {
    try {
      const text = await file.text();
      setOpened({ name: file.name, report: readHardReport(text) });
      setFailure(null);
      try {
        localStorage.setItem(kStored, JSON.stringify({ name: file.name, text: JSON.stringify(JSON.parse(text)) }));
      } catch {
        say("The report is too large to be kept: a reload will ask for it again.");
      }
    } catch (reason) {
      setFailure(`${file.name} cannot be shown: ${(reason as Error).message}`);
    }
  };
  const close = () => {
    localStorage.removeItem(kStored);
    setOpened(null);
    setFailure(null);
  };
  return [opened, open, close, failure];
}

function CellButton({ cell, chosen, onChoose }: { cell: HardCell; chosen: boolean; onChoose: () => void }) {
  const bias = biasText(shownCheck(cell));
  const defect = cell.defects.length > 0;
  return (
    <button class={`hard-cell ${cell.verdict}`} aria-expanded={chosen} onClick={onChoose}>
      <b>
        <span aria-hidden="true">{kVerdictMarks[cell.verdict]}</span> {kVerdictWords[cell.verdict]}
      </b>
      <small>{defect ? cell.defects[0] : cell.verdict === "not_applicable" ? cell.reason : bias || cell.text}</small>
    </button>
  );
}

function Detail({ row, cell, onClose }: { row: HardCaseRow; cell: HardCell; onClose: () => void }) {
  return (
    <section class="panel stack hard-detail" aria-labelledby="hard-detail">
      <div class="row">
        <h2 id="hard-detail" class="hard-fill">
          {row.name}, {cell.entry}: {cell.text}
        </h2>
        <button class="quiet" aria-label="Close the details" onClick={onClose}>
          ✕
        </button>
      </div>
      <dl class="facts">
        <dt>What it strains</dt>
        <dd>{Array.isArray(row.strains) ? row.strains.join(", ") : row.strains || "–"}</dd>
        <dt>Known answer</dt>
        <dd>{row.text}</dd>
        {cell.reason && (
          <>
            <dt>Why</dt>
            <dd>{cell.reason}</dd>
          </>
        )}
        {cell.defects.length > 0 && (
          <>
            <dt>Defects</dt>
            <dd>{cell.defects.join("; ")}</dd>
          </>
        )}
        {cell.notes.length > 0 && (
          <>
            <dt>Notes</dt>
            <dd>{cell.notes.join("; ")}</dd>
          </>
        )}
        <dt>NaN, infinite, negative</dt>
        <dd>
          {countText(cell.nan_count)}, {countText(cell.infinity_count)}, {countText(cell.negative_count)}
        </dd>
        <dt>Render time</dt>
        <dd>{secondsText(cell.seconds)}</dd>
        {row.scene && (
          <>
            <dt>Scene</dt>
            <dd>
              <a href={`/scenes/${encodeURIComponent(row.scene)}`}>{row.scene}</a>
            </dd>
          </>
        )}
        <dt>Jobs</dt>
        <dd>
          {cell.jobs.length === 0
            ? "not kept (photonctl hard-cases --keep-jobs keeps those that hold, too)"
            : cell.jobs.map((job, i) => (
                <span key={job}>
                  {i > 0 && ", "}
                  <a href={`/jobs/${job}`}>{job}</a>
                </span>
              ))}
        </dd>
      </dl>
      {cell.checks.length > 0 && (
        <div class="scroll-x" tabIndex={0} role="group" aria-label="Checks">
          <table>
            <thead>
              <tr>
                <th scope="col">Check</th>
                <th scope="col">Found</th>
                <th scope="col" class="number">Bias ± standard error</th>
                <th scope="col" class="number">May be</th>
                <th scope="col">Worst pixel</th>
              </tr>
            </thead>
            <tbody>
              {cell.checks.map((check, i) => (
                <tr key={i}>
                  <td>
                    {check.layer} {plainName(check.relation)}
                  </td>
                  <td>
                    {check.holds ? "✓" : "✕"} {check.text}
                  </td>
                  <td class="number">{biasText(check) || "–"}</td>
                  <td class="number">{mayBeText(check) || "–"}</td>
                  <td>{check.worst_pixel ? `${check.worst_pixel.x}, ${check.worst_pixel.y}` : "–"}</td>
                </tr>
              ))}
            </tbody>
          </table>
        </div>
      )}
    </section>
  );
}

function Table({ report }: { report: HardReport }) {
  const [query, change] = useQuery();
  const breaking = query.only === "breaks";
  const rows = breaking ? onlyBreaking(report) : report.cases;
  const [chosenCase, chosenEntry] = (query.cell ?? "").split("|");
  const row = report.cases.find((other) => other.name === chosenCase);
  const cell = row?.cells.find((other) => other.entry === chosenEntry);
  const { summary } = report;
  const all = summary.holds + summary.breaks + summary.not_applicable;
  return (
    <div class="stack">
      <section class="panel stack" aria-labelledby="hard-table">
        <div class="row">
          <h2 id="hard-table" class="hard-fill">
            {summary.holds} of {all} cells hold, {summary.breaks} break, {summary.not_applicable} are not applicable
          </h2>
          <label class="row">
            <input type="checkbox" checked={breaking} onChange={(event) => change({ only: event.currentTarget.checked ? "breaks" : null })} />
            Only cases that break
          </label>
          <button onClick={() => saveText(hardCsv(report), "text/csv", "hard-cases.csv")}>CSV</button>
          <button onClick={() => saveText(hardLatex(report), "application/x-tex", "hard-cases.tex")}>LaTeX</button>
        </div>
        <p class="muted small">
          photond {report.version}, {report.form} form, {report.seeds} seeds, {report.jobs} jobs in {secondsText(report.seconds)}.{" "}
          {summary.defects === 0 ? "No NaN, infinity, negative radiance, failed or hanging job in any cell." : `Defects in ${summary.defects} cells.`} The chance that a whole
          table without a fault has one wrong "breaks" is {report.false_alarm}.
        </p>
        {rows.length === 0 ? (
          <p class="empty">No case breaks.</p>
        ) : (
          <div class="scroll-x" tabIndex={0} role="group" aria-label="Cases and methods">
            <table class="hard-table">
              <thead>
                <tr>
                  <th scope="col">Case</th>
                  {report.entries.map((entry) => (
                    <th key={entry.label} scope="col">
                      {plainName(entry.label)}
                    </th>
                  ))}
                </tr>
              </thead>
              <tbody>
                {rows.map((one) => (
                  <tr key={one.name}>
                    <th scope="row">{one.name}</th>
                    {one.test && one.cells.length === 0 ? (
                      <td colSpan={report.entries.length} class="muted">
                        covered by the test {one.test}
                      </td>
                    ) : (
                      report.entries.map((entry) => {
                        const found = one.cells.find((other) => other.entry === entry.label);
                        const key = `${one.name}|${entry.label}`;
                        return (
                          <td key={entry.label}>
                            {found ? <CellButton cell={found} chosen={query.cell === key} onChoose={() => change({ cell: query.cell === key ? null : key })} /> : "–"}
                          </td>
                        );
                      })
                    )}
                  </tr>
                ))}
              </tbody>
            </table>
          </div>
        )}
      </section>
      {row && cell && <Detail row={row} cell={cell} onClose={() => change({ cell: null })} />}
    </div>
  );
}

export function HardCases() {
  const [opened, open, close, failure] = useReport();
  const [over, setOver] = useState(false);
  const input = useRef<HTMLInputElement>(null);
  useEffect(() => {
    const drag = (event: DragEvent) => {
      event.preventDefault();
      setOver(event.type === "dragover");
      const file = event.type === "drop" ? event.dataTransfer?.files[0] : undefined;
      if (file) void open(file);
    };
    for (const type of ["dragover", "dragleave", "drop"] as const) document.addEventListener(type, drag);
    return () => {
      for (const type of ["dragover", "dragleave", "drop"] as const) document.removeEventListener(type, drag);
    };
  }, []);
  const choose = (
    <>
      <input
        ref={input}
        class="visually-hidden"
        type="file"
        accept=".json,application/json"
        aria-label="Report of hard cases"
        tabIndex={-1}
        onChange={(event) => {
          const file = event.currentTarget.files?.[0];
          if (file) void open(file);
          event.currentTarget.value = "";
        }}
      />
      <button class={opened ? undefined : "primary"} onClick={() => input.current!.click()}>
        Open a report
      </button>
    </>
  );
  return (
    <>
      <Title text="Hard cases">
        {opened && (
          <>
            <span class="muted">{opened.name}</span>
            <button class="quiet" onClick={close}>
              Close it
            </button>
            {choose}
          </>
        )}
      </Title>
      {failure && (
        <p class="notice failed" role="alert">
          {failure}
        </p>
      )}
      {opened ? (
        <Table report={opened.report} />
      ) : (
        <div class={over ? "panel hard-empty over" : "panel hard-empty"}>
          <p>
            Scenes whose answer is known, and methods that may miss it: every method is rendered on every case, and its bias held against its standard error.
          </p>
          <p>The table is measured from the command line, for it takes minutes to hours:</p>
          <p class="row">
            <code>{kCommand}</code>
            <button onClick={() => navigator.clipboard.writeText(kCommand).then(() => say("Copied."), sayFailure)}>Copy</button>
          </p>
          <p class="row">{choose} <span class="by-mouse">or drop hard-cases.json anywhere on this page.</span></p>
        </div>
      )}
    </>
  );
}
