// One job: its picture, what became of it, what it took, and how to repeat it.

import "./job.css";

import { useLocation, useRoute } from "preact-iso";
import { useEffect, useRef, useState } from "preact/hooks";

import { getJson, Problem, sendJson } from "../api/client";
import { connection, listen } from "../api/events";
import { isOver, type Job, type Method, type Page } from "../api/types";
import { useKeys } from "../app/keyboard";
import { Title } from "../app/title";
import { errorWithInterval } from "../ui/error_interval";
import { kNone, percentText, plainName, secondsText, sizeText, stopText, timeText } from "../ui/format";
import { momentText } from "../ui/moment_text";
import { useRemote } from "../ui/remote";
import { sceneName } from "../ui/scene_names";
import { say, sayFailure } from "../ui/toasts";
import { Actions, doNow, type Asked } from "./actions";
import { ErrorCurve } from "./error_chart";
import { Errors } from "./errors";
import { Life } from "./life";
import { Log } from "./log";
import { Counts, Memory, Stages } from "./measures";
import { changesMore, withEvent } from "./merge";
import { PicturePanel, referenceJobs } from "./picture_panel";
import { Files, Repeat } from "./repeat";
import { RequestPanel } from "./request_panel";

/** The job at an address, as events say. */
function useJob(id: string) {
  const remote = useRemote<Job>(`/v1/jobs/${encodeURIComponent(id)}`);
  const held = useRef<Job | null>(null);
  held.current = remote.data;
  useEffect(
    () =>
      listen((event) => {
        if (event.type === "gap") return remote.reload();
        if (event.type === "status" || event.change.id !== id || !held.current) return;
        const more = changesMore(held.current, event.change);
        remote.patch((job) => withEvent(job, event.type, event.change));
        if (more) remote.reload();
      }),
    [id],
  );
  return remote;
}

const kProbed = 30;

/** The next job by number that is there; removed ones leave gaps. */
async function neighbourOf(id: string, step: 1 | -1): Promise<string | null> {
  const number = Number(id.replace(/^J/, ""));
  for (let other = number + step; other > 0 && Math.abs(other - number) <= kProbed; other += step)
    try {
      return (await getJson<Job>(`/v1/jobs/J${other}`)).id;
    } catch (failure) {
      if (!(failure instanceof Problem) || failure.status !== 404) return null;
    }
  return null;
}

export function JobPage() {
  const { id = "" } = useRoute().params;
  const { route } = useLocation();
  const { data: job, failure, reload } = useJob(id);
  const go = (step: 1 | -1) =>
    void neighbourOf(id, step).then((other) => (other ? route(`/jobs/${other}`) : say(step > 0 ? "There is no newer job." : "There is no older job.")));
  // Of the address alone, so that one can leaf through jobs faster than they load.
  useKeys(
    "Job",
    [
      { key: "]", text: "newer or older job", run: () => go(1) },
      { key: "[", text: "newer or older job", run: () => go(-1) },
      { key: "u", text: "up to all jobs", run: () => route("/jobs") },
    ],
    [id],
  );
  if (failure && !job)
    return (
      <>
        <Title text={id} />
        <div class="panel empty">
          <p>{failure.message}</p>
          <div class="row job-missing">
            <button onClick={reload}>Ask again</button>
            <a class="button" href="/jobs">
              All jobs
            </a>
          </div>
        </div>
      </>
    );
  if (!job)
    return (
      <>
        <Title text={id} />
        <p class="muted" role="status">
          Loading …
        </p>
      </>
    );
  return <Loaded key={job.id} job={job} reload={reload} stale={failure !== null} go={go} />;
}

function Facts({ job }: { job: Job }) {
  const { request } = job;
  const references = referenceJobs(job);
  const moment = momentText(request);
  const error = errorWithInterval(job.error_now?.value, job.error_now?.interval);
  const labels = Object.entries(request.labels);
  const leftOut = job.statistics?.left_out ?? [];
  return (
    <dl class="facts">
      <dt>Scene</dt>
      <dd>
        <a href={`/scenes/${encodeURIComponent(request.scene)}`} title={request.scene}>{sceneName(request.scene)}</a>
      </dd>
      {moment && (
        <>
          <dt>Moment</dt>
          <dd>{moment}</dd>
        </>
      )}
      <dt>Method</dt>
      <dd>
        {plainName(request.method.name)} <span class="muted">on {request.method.device}</span>
      </dd>
      <dt>Size</dt>
      <dd>{sizeText(request.image)}</dd>
      <dt>Ends after</dt>
      <dd>{stopText(request.stop)}</dd>
      <dt>Passes</dt>
      <dd>
        {job.passes_done.toLocaleString("en")} <span class="muted">in {secondsText(job.seconds)} of rendering</span>
      </dd>
      <dt>Error now</dt>
      <dd>
        {error}
        {error !== kNone && <span class="muted">, {plainName(job.error_now!.metric)}</span>}
      </dd>
      <dt>Created</dt>
      <dd>{timeText(job.created)}</dd>
      {job.finished && (
        <>
          <dt>Finished</dt>
          <dd>{timeText(job.finished)}</dd>
        </>
      )}
      {job.comparison && (
        <>
          <dt>Study</dt>
          <dd>
            <a href={`/studies/${job.comparison}`}>{job.comparison}</a>
          </dd>
        </>
      )}
      {references.length > 0 && (
        <>
          <dt>Reference</dt>
          <dd>
            {references.map((id, index) => (
              <span key={id}>
                {index > 0 && " and "}
                <a href={`/jobs/${id}`}>{id}</a>
              </span>
            ))}
            {references.length > 1 && <span class="muted">, two films of one image</span>}
          </dd>
        </>
      )}
      {leftOut.length > 0 && (
        <>
          <dt>Left out</dt>
          <dd>
            {leftOut.map(({ kind, text }) => (
              <div key={kind}>{text}</div>
            ))}
          </dd>
        </>
      )}
      {labels.length > 0 && (
        <>
          <dt>Labels</dt>
          <dd class="row">
            {labels.map(([key, value]) => (
              <a key={key} href={`/jobs?label=${encodeURIComponent(`${key}=${value}`)}`}>
                {key}={value}
              </a>
            ))}
          </dd>
        </>
      )}
    </dl>
  );
}

function Failure({ job }: { job: Job }) {
  if (!job.failure) return null;
  return (
    <div class="notice failed" role="alert">
      <strong>{job.failure.title}</strong>
      <p>{job.failure.detail}</p>
      {job.failure.errors && job.failure.errors.length > 0 && (
        <ul>
          {job.failure.errors.map((fault) => (
            <li key={fault.pointer + fault.detail}>
              <code>{fault.pointer}</code> {fault.detail}
            </li>
          ))}
        </ul>
      )}
    </div>
  );
}

function Panel({ title, children }: { title: string; children: preact.ComponentChildren }) {
  const id = `job-${title.toLowerCase().replaceAll(/\W+/g, "-")}`;
  return (
    <section class="panel" aria-labelledby={id}>
      <h2 id={id}>{title}</h2>
      {children}
    </section>
  );
}

function Loaded({ job, reload, stale, go }: { job: Job; reload: () => void; stale: boolean; go: (step: 1 | -1) => void }) {
  const { route } = useLocation();
  const methods = useRemote<Page<Method>>("/v1/methods").data?.items ?? [];
  const [asked, ask] = useState<Asked>(null);
  const over = isOver(job.state);
  useKeys(
    "This job",
    [
      { key: "e", text: "clone and edit", run: () => route(`/render?from=${job.id}`) },
      { key: "c", text: "cancel", run: () => (over ? say(`${job.id} is over.`) : doNow(job, { kind: "cancel" }, "cancelled; what it rendered stays", reload).catch(sayFailure)) },
      {
        key: "r",
        text: "retry",
        run: () =>
          job.state === "failed" || job.state === "cancelled"
            ? doNow(job, { kind: "retry" }, "is queued again", reload).catch(sayFailure)
            : say(`${job.id} is ${job.state}: a retry is for jobs that failed or were cancelled.`),
      },
    ],
    [job.id, job.state],
  );
  const { statistics } = job;
  const repeat = () =>
    void sendJson<Job>("POST", `/v1/jobs/${job.id}/repeat`).then((made) => {
      say(`${job.id} is repeated as ${made.id}.`);
      route(`/jobs/${made.id}`);
    }, sayFailure);
  const request = (
    <Panel title="Request">
      <RequestPanel job={job} methods={methods} />
    </Panel>
  );
  return (
    <div class="job-room">
      <Title text={job.id}>
        <Actions job={job} onChanged={reload} asked={asked} ask={ask} />
      </Title>
      <div class="row job-standing" role="status">
        <span class={`state ${job.state}`}>{job.state}</span>
        {job.state === "queued" && job.waiting_for && <span class="muted">waits for {job.waiting_for}</span>}
        {job.role !== "render" && <span class="muted">{job.role}</span>}
        {job.state === "running" && (
          <>
            <progress value={job.progress} max={1} aria-label="Progress" />
            <span>{percentText(job.progress)}</span>
          </>
        )}
        {(stale || connection.value === "lost") && <span class="fault">The daemon does not answer: this is how it was.</span>}
        <span class="row job-neighbours">
          <button class="quiet" title="[" onClick={() => go(-1)}>
            ← Older
          </button>
          <button class="quiet" title="]" onClick={() => go(1)}>
            Newer →
          </button>
        </span>
      </div>
      <Failure job={job} />
      {statistics?.shared && (
        <p class="notice" role="status">
          {statistics.shared.warning} {job.role === "render" && <button onClick={repeat}>Run it again</button>}
        </p>
      )}
      <div class="job-top">
        <div class="stack">
          <PicturePanel job={job} />
          <Panel title="State over time">
            <Life job={job} />
          </Panel>
        </div>
        <div class="stack">
          <Panel title="Facts">
            <Facts job={job} />
          </Panel>
          <Panel title="Error">
            <ErrorCurve curve={job.curve} target={job.request.stop.target} running={!over} />
            {statistics && <Errors statistics={statistics} />}
          </Panel>
        </div>
      </div>
      <div class="job-halves">
        <div class="stack">
          {statistics ? (
            <>
              <Panel title="Time by stage">
                <Stages statistics={statistics} />
              </Panel>
              <Panel title="Memory">
                <Memory statistics={statistics} />
              </Panel>
              <Panel title="Counts and rates">
                <Counts statistics={statistics} />
              </Panel>
            </>
          ) : (
            <>
              <Panel title="Time and memory">
                <p class="muted">{over ? "The job ended before it could be measured." : "Measured when the job is over."}</p>
              </Panel>
              {request}
            </>
          )}
        </div>
        <div class="stack">
          {statistics && request}
          <Panel title="Repeat it">
            <Repeat job={job} methods={methods} />
          </Panel>
          <Panel title="Files">
            <Files job={job} />
          </Panel>
          <Panel title="Log">
            <Log job={job} />
          </Panel>
        </div>
      </div>
    </div>
  );
}
