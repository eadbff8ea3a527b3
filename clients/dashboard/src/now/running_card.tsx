// One running job: its picture as it becomes, how far it is, and how wrong it still is.

import { useEffect, useMemo, useState } from "preact/hooks";

import { sendJson } from "../api/client";
import { listen } from "../api/events";
import type { CurvePoint, Job, JobSummary } from "../api/types";
import { errorPoints, lineOf } from "../job/error_points";
import { ActionButton } from "../ui/action_button";
import { errorWithInterval, type DrawnError } from "../ui/error_interval";
import { kNone, numberText, plainName, sizeText, stopText } from "../ui/format";
import { LiveChart } from "../ui/live_chart";
import { useLivePreview } from "../ui/live_preview";
import { PictureFrame } from "../ui/picture";
import { passesText, progressText } from "../ui/progress";
import { useRemote } from "../ui/remote";
import { sceneName } from "../ui/scene_names";
import { say } from "../ui/toasts";

/** The job's curve: as it was when the card appeared, and what events have added. */
function useCurve(job: Job | null): CurvePoint[] {
  const [added, setAdded] = useState<CurvePoint[]>([]);
  const id = job?.id;
  useEffect(() => {
    setAdded([]);
    return listen((event) => {
      if (event.type === "curve" && event.change.id === id) setAdded((old) => [...old, ...(event.change.curve ?? [])]);
    });
  }, [id]);
  return useMemo(() => {
    const points = new Map([...(job?.curve ?? []), ...added].map((point) => [point.passes, point]));
    return [...points.values()].sort((a, b) => a.passes - b.passes);
  }, [job, added]);
}

function ErrorSoFar({ row, job }: { row: JobSummary; job: Job | null }) {
  const curve = useCurve(job);
  const metric = row.error_now?.metric ?? Object.keys(curve.at(-1)?.metrics ?? {})[0];
  const points = useMemo(() => errorPoints(curve, metric ? [metric] : [], "seconds"), [curve, metric]);
  const errors = points.drawn[0] ?? [];
  const y = useMemo(() => lineOf(errors), [points]);
  if (!metric)
    return <p class="muted small now-error">{job && !job.request.reference ? "No reference: its error is not measured." : "No error measured yet."}</p>;
  const last = curve.at(-1);
  const now = row.error_now ? errorWithInterval(row.error_now.value, row.error_now.interval) : kNone;
  const text = (error: DrawnError | null | undefined) => (error?.isBound ? `below ${numberText(error.at)}` : numberText(error?.at));
  return (
    <div class="now-error">
      <span>
        <span class="muted">{plainName(metric)}</span> <strong>{now === kNone ? errorWithInterval(last?.metrics[metric], last?.intervals?.[metric]) : now}</strong>
      </span>
      {errors.length > 1 && (
        <LiveChart
          label={`${plainName(metric)} against seconds, both logarithmic: from ${text(errors[0])} to ${text(errors.at(-1))}`}
          x={points.x}
          y={y}
          height={44}
          errors={errors}
        />
      )}
    </div>
  );
}

export function RunningCard({ row }: { row: JobSummary }) {
  const path = `/v1/jobs/${row.id}`;
  const { data: job } = useRemote<Job>(path);
  const image = useLivePreview(`${path}/preview.png?max_size=320`, row.passes_done);
  const cancel = () => sendJson("DELETE", path).then(() => say(`${row.id} stops; what it has rendered stays.`));
  const titleId = `running-${row.id}`;
  return (
    <article class="panel now-card" aria-labelledby={titleId}>
      <a href={`/jobs/${row.id}`} class="now-card-picture" tabIndex={-1} aria-hidden="true">
        <PictureFrame image={image} alt="" ratio={row.width / row.height} waiting={row.passes_done ? "" : "before the first pass"} />
      </a>
      <div class="now-card-text">
        <header>
          <h3 id={titleId}>
            <a href={`/jobs/${row.id}`}>{plainName(row.method)}</a>
          </h3>
          <ActionButton class="quiet" busy="Cancelling …" until={row.id} run={cancel} label={`Cancel ${row.id}`}>
            Cancel
          </ActionButton>
        </header>
        <p class="muted small">
          {row.id} · {sceneName(row.scene)} · {sizeText(row)} · {row.device}
          {row.role === "reference" ? " · a reference, for others to be measured against" : ""}
          {row.comparison && (
            <>
              {" "}
              · <a href={`/studies/${row.comparison}`}>study {row.comparison}</a>
            </>
          )}
        </p>
        <progress max={1} value={row.progress} aria-label={`Progress of ${row.id}`} />
        <p class="now-card-numbers small">
          <span>{progressText(row)}</span>
          <span class="muted" title={job ? `until ${stopText(job.request.stop)}` : undefined}>
            {passesText(row.passes_done, row.seconds)}
          </span>
        </p>
        <ErrorSoFar row={row} job={job} />
      </div>
    </article>
  );
}
