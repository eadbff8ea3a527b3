// What has ended lately: pictures of jobs, and the studies with what they found.

import { useEffect, useRef } from "preact/hooks";

import type { Comparison, ComparisonSummary, JobSummary, Page } from "../api/types";
import { errorNowText } from "../ui/error_interval";
import { plainName, secondsText, timeText } from "../ui/format";
import { Picture } from "../ui/picture";
import { useRemote } from "../ui/remote";
import { sceneName } from "../ui/scene_names";
import { StateMark } from "../ui/state";

const kStudiesShown = 5;

function RecentJob({ row }: { row: JobSummary }) {
  const error = errorNowText(row.error_now);
  return (
    <li>
      <a class="now-recent-job" href={`/jobs/${row.id}`}>
        <Picture
          path={row.passes_done > 0 ? `/v1/jobs/${row.id}/preview.png?max_size=320` : null}
          version={`${row.state} ${row.passes_done}`}
          alt=""
          ratio={4 / 3}
          waiting={row.passes_done > 0 ? "" : "no pass, no picture"}
        />
        <span class="now-recent-title">
          <strong>{plainName(row.method)}</strong> <StateMark state={row.state} />
        </span>
        <span class="muted small">
          {row.id} · {sceneName(row.scene)} · {secondsText(row.seconds)}
          {row.role === "reference" ? " · reference" : ""}
        </span>
        <span class={row.failure ? "small now-failure" : "muted small"} title={row.failure ?? undefined}>
          {row.failure ?? (error || `at ${timeText(row.finished)}`)}
        </span>
      </a>
    </li>
  );
}

export function RecentJobs({ recent }: { recent: JobSummary[] }) {
  if (recent.length === 0) return null;
  return (
    <section class="panel" aria-labelledby="now-recent">
      <h2 id="now-recent">Recently finished</h2>
      <ul class="now-recent">
        {recent.map((row) => (
          <RecentJob key={row.id} row={row} />
        ))}
      </ul>
      <p class="small">
        <a href="/jobs">All jobs</a>
      </p>
    </section>
  );
}

/** What a study that is over has come to. */
function Finding({ id }: { id: string }) {
  const { data: study } = useRemote<Comparison>(`/v1/comparisons/${id}`);
  const found = study?.headlines.find((headline) => headline.metric === study.request.metrics[0]);
  return found ? <strong class="now-finding">{found.text}</strong> : null;
}

function StudyRow({ study }: { study: ComparisonSummary }) {
  return (
    <li class="now-study">
      <span>
        <a href={`/studies/${study.id}`}>{study.request.entries.map((entry) => entry.label ?? plainName(entry.method.name)).join(", ")}</a>{" "}
        <span class="muted">on {sceneName(study.request.scene)}</span>
      </span>
      <span class="small">
        <StateMark state={study.state} /> <span class="muted">{study.id}</span>
      </span>
      {study.progress !== undefined && (study.state === "running" || study.state === "queued") && (
        <progress max={1} value={study.progress} aria-label={`Progress of study ${study.id}`} />
      )}
      {study.state === "succeeded" && <Finding id={study.id} />}
    </li>
  );
}

/** The newest studies, asked for again when the jobs of one have changed. */
export function RecentStudies({ jobs }: { jobs: JobSummary[] }) {
  const { data, failure, reload } = useRemote<Page<ComparisonSummary>>(`/v1/comparisons?limit=${kStudiesShown}`);
  const states = jobs.flatMap((job) => (job.comparison ? [`${job.id} ${job.state}`] : [])).join();
  const read = useRef(states);
  useEffect(() => {
    if (states === read.current) return;
    read.current = states;
    reload();
  }, [states]);
  if (failure && !data) return <p class="notice failed">The studies cannot be listed: {failure.message}</p>;
  if (!data || data.items.length === 0) return null;
  return (
    <section class="panel" aria-labelledby="now-studies">
      <h2 id="now-studies">Studies</h2>
      <ul class="now-studies">
        {data.items.map((study) => (
          <StudyRow key={study.id} study={study} />
        ))}
      </ul>
      <p class="small">
        <a href="/studies">All studies</a>
      </p>
    </section>
  );
}
