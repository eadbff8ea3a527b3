// One comparison: who is better, by how much, and everything that was measured.

import "./study.css";

import { useLocation, useRoute } from "preact-iso";
import { useEffect, useMemo, useRef } from "preact/hooks";

import { download, Problem, sendJson } from "../api/client";
import { isOver, type Comparison, type ComparisonReport } from "../api/types";
import { Title } from "../app/title";
import { useQuery } from "../app/url_state";
import { ActionButton } from "../ui/action_button";
import { percentText, stopText } from "../ui/format";
import { sceneName } from "../ui/scene_names";
import { StateMark } from "../ui/state";
import { sayFailure } from "../ui/toasts";
import { floorsOf } from "./bias";
import { BiasPanel } from "./bias_panel";
import { unequalBounces } from "./bounces";
import { ErrorFigure, Swatch } from "./error_figure";
import { figuresTable } from "./figures_table";
import { useLiveStudy, type LiveStudy } from "./live_study";
import { BestByTime, MemoryFigure } from "./memory_figure";
import { metricText } from "./metric_texts";
import { defaultBand, frontWithMemory, idealSlope, isNoiseKnown, referenceJobs, rowName, seriesOf, type Band } from "./series";
import { Remarks } from "./remarks";
import { Strips, type PictureKind } from "./strips";
import { JobsOfStudy, Repetition } from "./study_jobs";
import { StudyNow } from "./study_now";
import { CostTable, FiguresView } from "./tables_view";

const kBands: Record<Band, string> = {
  range: "lowest to highest seed",
  interval: "95 % interval of the mean",
  noise: "90 % by the reference's noise",
  none: "none",
};
/** Those that there can be: over seeds where there are several, of the reference's noise where it is known. */
const bandsOf = (seeds: number, noiseKnown: boolean): Band[] => [...(seeds > 1 ? (["range", "interval"] as const) : []), ...(noiseKnown ? (["noise"] as const) : []), "none"];

const capitalised = (text: string): string => text[0]!.toUpperCase() + text.slice(1);

export const studyTitle = (request: Comparison["request"]): string =>
  request.title ??
  `${sceneName(request.scene)}: ${request.entries.map((entry) => entry.label ?? entry.method.name).join(", ")}`;

function VerdictPanel({ report, metric }: { report: ComparisonReport; metric: string }) {
  const found = report.headlines.find((headline) => headline.metric === metric);
  const main = found && report.verdicts[found.verdict];
  const over = isOver(report.state);
  if (!found || !main)
    return (
      <section class="panel study-verdict" aria-label="Verdict">
        <h2>{over ? "Nothing to judge" : "No verdict yet"}</h2>
        <p class="muted">
          {!over
            ? report.reference?.state && !isOver(report.reference.state)
              ? "The reference is rendered first; then every entry in turn."
              : "It is there as soon as two entries have been measured."
            : report.table.length < 2
              ? "There is one entry, and nothing to compare it with."
              : `No entry reached an error of ${metric} with every seed.`}
        </p>
      </section>
    );
  const others = report.verdicts.filter((verdict) => verdict.metric === metric && verdict !== main);
  return (
    <section class="panel study-verdict" aria-label="Verdict">
      <h2>
        {found.row !== null && <Swatch row={found.row} />} {found.text}
        {over ? "" : ", so far"}.
      </h2>
      <p>{capitalised(main.text)}.</p>
      {metricText(metric) && (
        <p class="muted small">
          {metric}: {metricText(metric)}.
        </p>
      )}
      {others.length > 0 && (
        <details>
          <summary>At other errors</summary>
          <ul>
            {others.map((verdict) => (
              <li key={verdict.error}>{capitalised(verdict.text)}.</li>
            ))}
          </ul>
        </details>
      )}
      {report.request.seeds.length === 1 && (
        <p class="muted small">One seed: how much chance has to do with it is not known. Repeat it with three seeds or more to have intervals.</p>
      )}
    </section>
  );
}

/** Which jobs lost processor time to other processes; what became of that, and what can still be done. */
function Disturbances({ study, report }: { study: LiveStudy; report: ComparisonReport }) {
  if (report.warnings.length === 0) return null;
  const left = isOver(report.state) ? report.jobs.filter((job) => job.warning) : [];
  const repeat = () => Promise.all(left.map((job) => sendJson("POST", `/v1/jobs/${job.id}/repeat`))).then(study.reload, sayFailure);
  return (
    <div class="notice">
      Other processes took a part of the processors:
      <ul>
        {report.warnings.map((warning) => (
          <li key={warning}>{warning}.</li>
        ))}
      </ul>
      {left.length > 0 && <button onClick={() => void repeat()}>Run {left.length === 1 ? left[0]!.id : `these ${left.length} jobs`} again</button>}
    </div>
  );
}

/** Rows that have light which the reference lacks. */
function Marks({ report }: { report: ComparisonReport }) {
  const marked = report.table.filter((row) => row.mark);
  if (marked.length === 0) return null;
  return (
    <div class="notice">
      Measured against a reference without some of their light:
      <ul>
        {marked.map((row) => (
          <li key={row.jobs[0]}>
            {rowName(row)}: {row.mark}.
          </li>
        ))}
      </ul>
    </div>
  );
}

function Progress({ report }: { report: ComparisonReport }) {
  if (isOver(report.state)) {
    if (report.state === "succeeded") return null;
    return (
      <p class="notice failed" role="status">
        The comparison {report.state === "failed" ? "failed in part" : "was cancelled"}: {report.job_states.succeeded} of {report.jobs.length} jobs succeeded.
        What follows is of those.
      </p>
    );
  }
  const done = report.job_states.succeeded;
  return (
    <div class="panel row" role="status">
      <StateMark state={report.state} />
      <span>
        {done} of {report.jobs.length} jobs done
      </span>
      <span class="study-fill">
        <progress value={report.progress} max={1} aria-label="Progress of the comparison" />
      </span>
      <span>{percentText(report.progress)}</span>
    </div>
  );
}

function Actions({ study, report }: { study: LiveStudy; report: ComparisonReport }) {
  const { route } = useLocation();
  const menu = useRef<HTMLDetailsElement>(null);
  const get = (kind: string) => {
    menu.current!.open = false;
    download(`/v1/comparisons/${report.id}/report.${kind}`, `${report.id}.${kind}`).catch(sayFailure);
  };
  const cancel = () =>
    sendJson("DELETE", `/v1/comparisons/${report.id}`).then(study.reload);
  const remove = () => {
    if (!window.confirm(`Remove ${report.id}, its jobs and their images? This cannot be undone.`)) return;
    sendJson("DELETE", `/v1/comparisons/${report.id}?purge=true`).then(() => route("/studies"), sayFailure);
  };
  return (
    <>
      {isOver(report.state) ? (
        <button class="quiet" onClick={remove}>
          Remove
        </button>
      ) : (
        <ActionButton class="danger" busy="Cancelling …" until={report.state} run={cancel}>
          Cancel
        </ActionButton>
      )}
      <details class="study-downloads" ref={menu}>
        <summary class="button">Download</summary>
        <div>
          <button onClick={() => get("html")}>Report, one page (.html)</button>
          <button onClick={() => get("csv")}>Every curve (.csv)</button>
          <button onClick={() => get("json")}>Everything (.json)</button>
        </div>
      </details>
      <a class="button" href={`/studies/new?from=${report.id}`}>
        Repeat or change it
      </a>
    </>
  );
}

/** Two films, where it is those; what is no mean of squares has their noise as a part all the same. */
function MeasuredBy({ report, metric }: { report: ComparisonReport; metric: string }) {
  const films = referenceJobs(report);
  const known = isNoiseKnown(report, metric);
  if (report.reference?.form !== "two_films" || films.length < 2) return null;
  return (
    <p class="muted small">
      Measured against {known ? "" : "the mean of "}two films of different seeds,{" "}
      {films.map((id, index) => (
        <span key={id}>
          {index > 0 && " and "}
          <a href={`/jobs/${id}`}>{id}</a>
        </span>
      ))}
      {known ? ", whose noise drops out." : `, whose noise is a part of ${metric}.`}
    </p>
  );
}

function useHidden(): [Set<number>, (hidden: Set<number>) => void] {
  const [query, change] = useQuery();
  const hidden = useMemo(() => new Set((query.hide ?? "").split(",").filter(Boolean).map(Number)), [query.hide]);
  return [hidden, (next) => change({ hide: [...next].sort((a, b) => a - b).join(",") || null })];
}

function Body({ study, report }: { study: LiveStudy; report: ComparisonReport }) {
  const [query, change] = useQuery();
  const metrics = report.request.metrics;
  const metric = metrics.includes(query.metric ?? "") ? query.metric! : metrics[0]!;
  const seeds = report.request.seeds.length;
  const unequal = unequalBounces(report.request);
  const noiseKnown = isNoiseKnown(report, metric);
  const bands = bandsOf(seeds, noiseKnown);
  const usualBand = defaultBand(seeds, noiseKnown);
  const band = bands.find((one) => one === query.band) ?? usualBand;
  const [hidden, setHidden] = useHidden();
  const series = useMemo(() => seriesOf(report, metric, band), [report, metric, band]);
  const withMemory = useMemo(() => frontWithMemory(series, report.table), [series]);
  const floors = useMemo(() => floorsOf(report.table, metric), [report, metric]);
  const noise = noiseKnown ? null : (report.table.map((row) => row.error[metric]?.reference).find((value) => value) ?? null);
  const leftOut = series.reduce((sum, one) => sum + one.leftOut, 0);
  const kind: PictureKind = query.picture === "error" || query.picture === "flip" ? query.picture : "image";
  const exposure = Number(query.ev) || 0;
  const name = `${report.id} ${sceneName(report.request.scene)}`;
  return (
    <div class="stack study-body">
      <Progress report={report} />
      <Disturbances study={study} report={report} />
      <StudyNow report={report} jobs={study.jobs} />
      <VerdictPanel report={report} metric={metric} />
      {unequal.length > 0 && <p class="notice">{unequal.join(" ")} What is missing stays as error, however long it renders.</p>}
      <Marks report={report} />
      {report.reference && report.reference.warnings.length > 0 && (
        <div class="notice">
          {report.reference.form === "two_films" ? "What the reference's noise leaves little of:" : "Errors near the reference's own noise are partly the reference's:"}
          <ul>
            {report.reference.warnings.map((warning) => (
              <li key={warning}>{warning}</li>
            ))}
          </ul>
        </div>
      )}
      <section class="panel stack study-tight" aria-labelledby="study-curves">
        <div class="row study-controls">
          <h2 id="study-curves" class="study-fill">
            Error against time
          </h2>
          {metrics.length > 1 && (
            <label class="study-inline">
              Error
              <select value={metric} onChange={(event) => change({ metric: event.currentTarget.value === metrics[0] ? null : event.currentTarget.value })}>
                {metrics.map((other) => (
                  <option key={other}>{other}</option>
                ))}
              </select>
            </label>
          )}
          {bands.length > 1 && (
            <label class="study-inline">
              Bands
              <select value={band} onChange={(event) => change({ band: event.currentTarget.value === usualBand ? null : event.currentTarget.value })}>
                {bands.map((value) => (
                  <option key={value} value={value}>
                    {kBands[value]}
                  </option>
                ))}
              </select>
            </label>
          )}
          {report.table.length > 1 && (
            <label class="study-inline">
              <input type="checkbox" checked={query.front !== "off"} onChange={(event) => change({ front: event.currentTarget.checked ? null : "off" })} />
              Pareto front
            </label>
          )}
        </div>
        <ErrorFigure
          title={`${name} ${metric}`}
          metric={metric}
          series={series}
          hidden={hidden}
          onHidden={setHidden}
          noise={noise}
          floors={floors}
          showFront={query.front !== "off" && report.table.length > 1}
        />
        <p class="muted small">
          Lines: {seeds === 1 ? "the one seed" : noiseKnown ? "the mean over the seeds" : "the mean of the logarithms over the seeds"}. Slopes: least squares over the last decade of time
          {idealSlope(metric) !== null && `; ${idealSlope(metric)} is noise alone, which halves as samples grow ${idealSlope(metric) === -1 ? "twofold" : "fourfold"}`}.
          {report.table.length > 1 && " The pale line beneath them is the Pareto front: the lowest error at each time."}
          {series.some((one) => one.points.some((point) => point.isBound)) && " Arrows: upper bounds, where an error is not told apart from 0."}
          {leftOut > 0 && ` ${leftOut === 1 ? "1 point is" : `${leftOut} points are`} 0 or below, which a logarithmic axis cannot show.`}
        </p>
        <MeasuredBy report={report} metric={metric} />
      </section>
      <section class="panel stack study-tight" aria-labelledby="study-times">
        <h2 id="study-times">Time to reach {metric}</h2>
        <FiguresView table={figuresTable("time_to_error", report.table, metric)} study={report.id} scene={report.request.scene} />
      </section>
      <Strips report={report} jobs={study.jobs} metric={metric} at={query.strip} kind={kind} exposure={exposure} change={change} />
      <section class="panel stack study-tight" aria-labelledby="study-errors">
        <h2 id="study-errors">{metric} after a time</h2>
        <FiguresView table={figuresTable("error_at_time", report.table, metric)} study={report.id} scene={report.request.scene} />
      </section>
      <BiasPanel report={report} metric={metric} />
      <div class="study-wide-panels">
        <section class="panel stack study-tight" aria-labelledby="study-memory">
          <h2 id="study-memory">Memory against error</h2>
          <MemoryFigure title={`${name} memory ${metric}`} metric={metric} rows={report.table} hidden={hidden} />
        </section>
        <section class="panel stack study-tight" aria-labelledby="study-front">
          <h2 id="study-front">Who has the lowest error when</h2>
          <BestByTime series={series} withMemory={withMemory} />
        </section>
      </div>
      <section class="panel stack study-tight" aria-labelledby="study-cost">
        <h2 id="study-cost">What it cost</h2>
        <CostTable rows={report.table} metrics={metrics} withMemory={withMemory} study={report.id} />
      </section>
      <section class="panel stack study-tight" aria-labelledby="study-jobs">
        <h2 id="study-jobs">Jobs</h2>
        <JobsOfStudy report={report} jobs={study.jobs} metric={metric} />
      </section>
      <section class="panel stack study-tight" aria-labelledby="study-repeat">
        <h2 id="study-repeat">To repeat it</h2>
        <Repetition report={report} />
      </section>
    </div>
  );
}

export function Study() {
  const id = useRoute().params.id!;
  const study = useLiveStudy(id);
  const report = study.data;
  const wasOver = useRef<boolean | null>(null);
  const over = report ? isOver(report.state) : null;
  // Who looks away while it runs sees from the tab that it is done.
  useEffect(() => {
    if (over && wasOver.current === false) document.title = `✓ ${document.title}`;
    wasOver.current = over;
  }, [over]);
  if (!report)
    return (
      <>
        <Title text={`Study ${id}`} />
        {study.failure ? (
          <div class="panel">
            <p class="notice failed">{study.failure.message}</p>
            {study.failure instanceof Problem && study.failure.status === 404 ? (
              <a href="/studies">All studies</a>
            ) : (
              <button onClick={study.reload}>Try again</button>
            )}
          </div>
        ) : (
          <p class="empty" role="status">
            Reading {id} …
          </p>
        )}
      </>
    );
  const { image, seeds, stop } = report.request;
  return (
    <>
      <Title text={studyTitle(report.request)}>
        <Actions study={study} report={report} />
      </Title>
      <p class="muted">
        {report.id}, <StateMark state={report.state} /> · {report.table.map(rowName).length} entries · {image.width} × {image.height} · {stopText(stop)} each ·{" "}
        {seeds.length === 1 ? "1 seed" : `${seeds.length} seeds`} · {report.jobs.length} jobs
      </p>
      <Remarks report={report} reload={study.reload} />
      {study.failure && <p class="notice failed">What is shown may be old: {study.failure.message}</p>}
      <Body study={study} report={report} />
    </>
  );
}
