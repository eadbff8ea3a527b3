// What every entry looks like: beside each other at the end, at one error, or at one time.

import { useEffect, useMemo, useState } from "preact/hooks";

import { sendJson } from "../api/client";
import { listen } from "../api/events";
import { isOver, type ComparisonReport, type Job, type JobState, type JobSummaryPage } from "../api/types";
import { errorNowText, shortError } from "../ui/error_interval";
import { kNone, numberText, percentText, secondsText } from "../ui/format";
import { Picture } from "../ui/picture";
import { useRemote } from "../ui/remote";
import { sayFailure } from "../ui/toasts";
import { Swatch } from "./error_figure";
import type { LiveJob } from "./live_study";
import { referenceJobs, rowName } from "./series";
import { readStrip, stripFilter, stripJobs, stripRequests, stripText, type StripAt } from "./strip_jobs";

export type PictureKind = "image" | "error" | "flip";

const kPictures: { kind: PictureKind; name: string; about: string }[] = [
  { kind: "image", name: "Images", about: "all at one exposure" },
  { kind: "error", name: "Relative error", about: "of each pixel; black 0.001 and less, white 10 and more, logarithmic" },
  { kind: "flip", name: "FLIP", about: "HDR-FLIP of each pixel; black 0, the same to the eye, white 1" },
];
const kPictureSize = 640;
const kStopsWithin = 16;

function picturePath(job: string, kind: PictureKind, exposure: number): string {
  if (kind === "image") return `/v1/jobs/${job}/preview.png?max_size=${kPictureSize}${exposure ? `&exposure=${exposure}` : ""}`;
  return kind === "error" ? `/v1/jobs/${job}/error.png` : `/v1/jobs/${job}/flip.png?range=hdr`;
}

interface Shown {
  key: string;
  name: string;
  row: number | null;
  job: string | null;
  state: JobState | null;
  progress: number;
  /** Passes or seconds so far; asks for a new picture while it changes. */
  version: number;
  /** "3.02 s, 117 passes, relative_mse 0.0123" */
  facts: string;
  /** Why there is no picture. */
  none: string;
}

interface StripProps {
  shown: Shown[];
  kind: PictureKind;
  exposure: number;
  ratio: number;
}

function Strip({ shown, kind, exposure, ratio }: StripProps) {
  return (
    <ul class="study-strip">
      {shown.map((one) => {
        // Of a job that has no end yet there is no map; the reference is what all are compared with.
        const map = kind !== "image";
        const path = one.job && !(map && (one.row === null || one.state !== "succeeded")) ? picturePath(one.job, kind, exposure) : null;
        const waiting = one.none || (map && one.row === null ? "what all are compared with" : one.state && !isOver(one.state) ? `${one.state}, ${percentText(one.progress)}` : "");
        return (
          <li key={one.key}>
            <a class="study-picture" href={one.job ? `/jobs/${one.job}` : undefined} aria-label={one.name}>
              {path ? (
                <Picture path={path} version={one.version} ratio={ratio} alt={`${kPictures.find((picture) => picture.kind === kind)!.name}: ${one.name}`} waiting={waiting} />
              ) : (
                <span class="study-no-picture" style={{ aspectRatio: String(ratio) }}>
                  {waiting || "no picture"}
                </span>
              )}
            </a>
            <p>
              <span class="study-picture-name">
                {one.row !== null && <Swatch row={one.row} />} {one.name}
              </span>
              <small class="muted">{one.facts || kNone}</small>
            </p>
          </li>
        );
      })}
    </ul>
  );
}

interface Props {
  report: ComparisonReport;
  jobs: ReadonlyMap<string, LiveJob>;
  metric: string;
  /** Of the address. */
  at: string | undefined;
  kind: PictureKind;
  exposure: number;
  change: (members: Record<string, string | null>) => void;
}

function referenceShown(report: ComparisonReport, jobs: ReadonlyMap<string, LiveJob>): Shown[] {
  const [job, other] = referenceJobs(report);
  if (!job) return [];
  const live = jobs.get(job);
  return [
    {
      key: "reference", name: "reference", row: null, job, state: report.reference!.state, progress: live?.progress ?? 0,
      version: live?.state === "succeeded" ? -1 : (live?.passes ?? 0), facts: other ? `${job}, one of two films` : job, none: "",
    },
  ];
}

/** The films of the comparison's own jobs: the first seed of each row. */
function endShown(report: ComparisonReport, jobs: ReadonlyMap<string, LiveJob>, metric: string): Shown[] {
  return report.table.map((row, index) => {
    const job = row.jobs[0]!;
    const live = jobs.get(job);
    const last = report.curves.find((curve) => curve.job === job)?.points.at(-1);
    const error = last ? shortError(last.metrics[metric], last.intervals?.[metric]) : kNone;
    const facts = live?.passes ? [secondsText(live.seconds), `${live.passes.toLocaleString("en")} passes`] : [];
    if (error !== kNone) facts.push(`${metric} ${error}`);
    return {
      key: job, name: rowName(row), row: index, job, state: live?.state ?? null, progress: live?.progress ?? 0,
      version: live && isOver(live.state) ? -1 : (live?.passes ?? 0), facts: facts.join(", "), none: "",
    };
  });
}

function useStripJobs(study: string, at: StripAt) {
  const path = at.kind === "end" ? null : `/v1/jobs?view=summary&limit=500&label=${encodeURIComponent(stripFilter(study, at))}`;
  const remote = useRemote<JobSummaryPage>(path);
  useEffect(() => {
    if (!path) return;
    let timer = 0;
    const stop = listen((event) => {
      if (event.type === "status") return;
      if (event.type !== "gap" && !remote.data?.items.some((job) => job.id === event.change.id)) return;
      clearTimeout(timer);
      timer = window.setTimeout(remote.reload, 200);
    });
    return () => {
      clearTimeout(timer);
      stop();
    };
  }, [path, remote.data]);
  return remote;
}

function endTitle(report: ComparisonReport): string {
  const { seconds, passes, target } = report.request.stop;
  if (seconds && !passes && !target) return `equal time, ${secondsText(seconds)} each`;
  if (passes && !seconds && !target) return `the end, ${passes.toLocaleString("en")} passes each`;
  return "the end of each job";
}

/** What is missing is rendered when asked for. */
function RenderMissing({ report, at, missing, onSent }: { report: ComparisonReport; at: StripAt; missing: number[]; onSent: () => void }) {
  const [busy, setBusy] = useState(false);
  const requests = useMemo(() => stripRequests(report, at), [report.id, stripText(at)]);
  const wanted = missing.filter((row) => requests[row]);
  if (wanted.length === 0) return null;
  const send = async () => {
    setBusy(true);
    try {
      for (const row of wanted) await sendJson<Job>("POST", "/v1/jobs", requests[row], crypto.randomUUID());
      onSent();
    } catch (failure) {
      sayFailure(failure);
    }
    setBusy(false);
  };
  return (
    <div class="row notice study-offer">
      <span class="study-fill">
        A comparison keeps each job's last film only.{" "}
        {at.kind === "error"
          ? `To see the entries at ${at.metric} ${numberText(at.error)}, each is rendered once more until its error is there.`
          : at.kind === "time"
            ? `To see the entries after ${secondsText(at.seconds)}, each is rendered once more for that long.`
            : ""}
      </span>
      <button class="primary" disabled={busy} onClick={() => void send()}>
        Render {wanted.length === 1 ? "1 picture" : `${wanted.length} pictures`}
      </button>
    </div>
  );
}

export function Strips({ report, jobs, metric, at: atText, kind: asked, exposure, change }: Props) {
  const at = readStrip(atText, metric);
  const kind = report.reference ? asked : "image";
  const found = useStripJobs(report.id, at);
  const first = report.table[0];
  const errors = [...new Set(report.table.flatMap((row) => (row.time_to_error[metric] ?? []).filter((level) => level.seconds !== null).map((level) => level.error)))].sort((a, b) => b - a);
  const times = (first?.error_at_time[metric] ?? []).map((level) => level.seconds);
  const ratio = report.request.image.width / report.request.image.height;
  const reached = (row: number) => at.kind !== "error" || report.table[row]!.time_to_error[metric]?.some((level) => level.error === at.error && level.seconds !== null);

  const matched = at.kind === "end" ? [] : stripJobs(report, found.data?.items ?? []);
  const missing = matched.flatMap((job, row) => (job || found.loading ? [] : [row]));
  const shown: Shown[] =
    at.kind === "end"
      ? endShown(report, jobs, metric)
      : report.table.map((row, index) => {
          const job = matched[index];
          return {
            key: `${index}`, name: rowName(row), row: index, job: job?.id ?? null, state: job?.state ?? null, progress: job?.progress ?? 0,
            version: job && isOver(job.state) ? -1 : (job?.passes_done ?? 0),
            facts: job?.passes_done ? [secondsText(job.seconds), `${job.passes_done.toLocaleString("en")} passes`, errorNowText(job.error_now)].filter(Boolean).join(", ") : "",
            none: job ? "" : !reached(index) ? "does not get there in its time" : found.loading ? "…" : "not rendered yet",
          };
        });
  const all = [...referenceShown(report, jobs), ...shown];
  const images = all.flatMap((one) => (one.job ? [`job:${one.job}`] : [])).slice(0, 9);
  const about = kPictures.find((picture) => picture.kind === kind)!.about;
  return (
    <section class="panel stack study-tight" aria-labelledby="study-strips">
      <div class="row">
        <h2 id="study-strips" class="study-fill">
          Pictures
        </h2>
        {images.length >= 2 && (
          <a class="button" href={`/compare?images=${images.join(",")}`}>
            Compare them closely
          </a>
        )}
      </div>
      <div class="row study-controls">
        <label class="study-inline">
          At
          <select value={stripText(at)} onChange={(event) => change({ strip: event.currentTarget.value || null })}>
            <option value="">{endTitle(report)}</option>
            <optgroup label="Equal error">
              {errors.map((error) => (
                <option key={error} value={`error ${error}`}>
                  {metric} {numberText(error)}
                </option>
              ))}
            </optgroup>
            <optgroup label="Equal time">
              {times.map((seconds) => (
                <option key={seconds} value={`time ${seconds}`}>
                  {secondsText(seconds)}
                </option>
              ))}
            </optgroup>
          </select>
        </label>
        {report.reference && (
          <div class="row" role="group" aria-label="What to show">
            {kPictures.map((picture) => (
              <button key={picture.kind} aria-pressed={kind === picture.kind} onClick={() => change({ picture: picture.kind === "image" ? null : picture.kind })}>
                {picture.name}
              </button>
            ))}
          </div>
        )}
        {kind === "image" && (
          <label class="study-inline">
            Exposure
            <input
              type="number"
              step="0.5"
              min={-kStopsWithin}
              max={kStopsWithin}
              value={exposure}
              onChange={(event) => {
                const stops = event.currentTarget.valueAsNumber;
                if (Math.abs(stops) <= kStopsWithin) change({ ev: stops ? String(stops) : null });
              }}
            />
            stops
          </label>
        )}
        <span class="muted small">
          {report.table.some((row) => row.seeds > 1) && "First seed of each entry; "}
          {about}.
        </span>
      </div>
      {found.failure && <p class="notice failed">{found.failure.message}</p>}
      {at.kind !== "end" && !found.loading && <RenderMissing report={report} at={at} missing={missing} onSent={found.reload} />}
      <Strip shown={all} kind={kind} exposure={exposure} ratio={ratio} />
    </section>
  );
}
