// The jobs of a comparison as they run, and what it takes to repeat it.

import { isOver, type ComparisonReport, type CurvePoint } from "../api/types";
import { errorWithInterval } from "../ui/error_interval";
import { percentText, secondsText, stopText } from "../ui/format";
import { sceneName } from "../ui/scene_names";
import { sayFailure, say } from "../ui/toasts";
import { StateMark } from "../ui/state";
import { Swatch } from "./error_figure";
import type { LiveJob } from "./live_study";
import { referenceJobs, rowName } from "./series";

interface Props {
  report: ComparisonReport;
  jobs: ReadonlyMap<string, LiveJob>;
  metric: string;
}

export function JobsOfStudy({ report, jobs, metric }: Props) {
  const rowOf = new Map(report.table.flatMap((row, index) => row.jobs.map((job) => [job, index] as const)));
  const references = referenceJobs(report);
  const line = (id: string, live: LiveJob | undefined, name: string, row: number | null, seed: string, point: CurvePoint | undefined) => (
    <tr key={id}>
      <td>
        <a href={`/jobs/${id}`}>{id}</a>
      </td>
      <td>
        {row !== null && <Swatch row={row} />} {name}
      </td>
      <td class="number">{seed}</td>
      <td>{live && <StateMark state={live.state} />}</td>
      {!isOver(report.state) && (
        <td class="study-progress">
          {live && !isOver(live.state) && (
            <>
              <progress value={live.progress} max={1} aria-label={`Progress of ${id}`} /> <small class="muted">{percentText(live.progress)}</small>
            </>
          )}
        </td>
      )}
      <td class="number">{live?.passes ? live.passes.toLocaleString("en") : ""}</td>
      <td class="number">{live?.seconds ? secondsText(live.seconds) : ""}</td>
      <td class="number">{point && errorWithInterval(point.metrics[metric], point.intervals?.[metric])}</td>
    </tr>
  );
  return (
    <div class="scroll-x" tabIndex={0} role="group" aria-label="Jobs">
      <table>
        <thead>
          <tr>
            <th scope="col">Job</th>
            <th scope="col">Entry</th>
            <th scope="col" class="number">Seed</th>
            <th scope="col">State</th>
            {!isOver(report.state) && <th scope="col">Progress</th>}
            <th scope="col" class="number">Passes</th>
            <th scope="col" class="number">Time</th>
            <th scope="col" class="number">{metric}</th>
          </tr>
        </thead>
        <tbody>
          {references.map((id, index) => line(id, jobs.get(id), references.length > 1 ? `reference, film ${index + 1} of 2` : "reference", null, "", undefined))}
          {report.jobs.flatMap((job) =>
            job.runs.map((run) =>
              line(
                run.id,
                jobs.get(run.id),
                run.id === job.id ? rowName(job) : `${rowName(job)} (${run.warning ? "disturbed, " : ""}does not count)`,
                run.id === job.id ? (rowOf.get(job.id) ?? null) : null,
                String(job.seed),
                report.curves.find((curve) => curve.job === run.id)?.points.at(-1),
              ),
            ),
          )}
        </tbody>
      </table>
    </div>
  );
}

function referenceText(report: ComparisonReport): string {
  const { reference } = report.request;
  if (!reference) return "none: errors are estimated from the passes";
  if (typeof reference === "string") return reference;
  const halves = report.reference?.form === "two_films" ? ", half of it in each of two films of different seeds" : "";
  return `${reference.method.name} on ${reference.method.device ?? "cpu"}, ${stopText(reference.stop)}${halves}`;
}

/** Every setting, and the line that sends them again. */
export function Repetition({ report }: { report: ComparisonReport }) {
  const body = JSON.stringify(report.request, null, 2);
  const line = `curl -X POST ${window.location.origin}/v1/comparisons -H 'Content-Type: application/json' --data @comparison.json`;
  const copy = (text: string) => navigator.clipboard.writeText(text).then(() => say("Copied."), sayFailure);
  return (
    <div class="stack study-tight">
      <dl class="facts">
        <dt>Scene</dt>
        <dd>
          <a href={`/scenes/${encodeURIComponent(report.request.scene)}`} title={report.request.scene}>{sceneName(report.request.scene)}</a>, {report.request.image.width} × {report.request.image.height} pixels
        </dd>
        <dt>Each job ends at</dt>
        <dd>{stopText(report.request.stop)}</dd>
        <dt>Reference</dt>
        <dd>{referenceText(report)}</dd>
        <dt>Seeds</dt>
        <dd>{report.request.seeds.join(", ")}</dd>
        <dt>Beside the jobs' clocks</dt>
        <dd>{report.overhead_seconds === null ? "not known yet" : `${secondsText(report.overhead_seconds)} of loading, building, measuring and saving`}</dd>
      </dl>
      <p>
        <code class="study-wrap">{line}</code>
      </p>
      <details>
        <summary>comparison.json, every default filled in</summary>
        <pre class="study-code" tabIndex={0} aria-label="comparison.json">
          {body}
        </pre>
      </details>
      <div class="row">
        <button onClick={() => void copy(body)}>Copy comparison.json</button>
        <button onClick={() => void copy(line)}>Copy the curl line</button>
      </div>
    </div>
  );
}
