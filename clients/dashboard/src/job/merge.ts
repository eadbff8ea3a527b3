// A job that is shown, kept as the daemon's events say.

import type { CurvePoint, Job, JobChange } from "../api/types";

/** The curve with points that were told later; a job that goes on from a film may tell some twice. */
export function withPoints(curve: CurvePoint[] | null, points: CurvePoint[]): CurvePoint[] {
  const known = new Set((curve ?? []).map((point) => point.passes));
  return [...(curve ?? []), ...points.filter((point) => !known.has(point.passes))].sort((a, b) => a.passes - b.passes);
}

export function withEvent(job: Job, type: "state" | "progress" | "curve", change: JobChange): Job {
  const { id: _, curve, priority, ...rest } = change;
  const next: Job = { ...job, ...rest };
  if (type === "curve" && curve) next.curve = withPoints(job.curve, curve);
  if (priority !== undefined) next.request = { ...job.request, priority };
  return next;
}

/** Whether what an event does not carry (links, the last of the curve) is to be asked for. */
export const changesMore = (before: Job, change: JobChange): boolean => change.state !== undefined && change.state !== before.state;

// -- its life as a line of spans ---------------------------------------------------------------------------------------

export interface Span {
  kind: "waiting" | "attempt";
  title: string;
  outcome: string;
  start: number;
  end: number;
  device: string | null;
  passes: number | null;
  reason: string | null;
}

/** What a job did when: it waits, is tried, perhaps lost and tried again. Times in milliseconds. */
export function spansOf(job: Job, now: number): Span[] {
  const spans: Span[] = [];
  let at = Date.parse(job.created);
  const wait = (until: number, title: string) => {
    if (until > at) spans.push({ kind: "waiting", title, outcome: "", start: at, end: until, device: null, passes: null, reason: null });
    at = Math.max(at, until);
  };
  job.attempts.forEach((attempt, index) => {
    const start = Date.parse(attempt.started);
    wait(start, index === 0 ? "queued" : "queued again");
    const end = attempt.finished ? Date.parse(attempt.finished) : Math.max(start, now);
    const goesOn = index > 0 && (job.attempts[index - 1]!.passes_done ?? 0) > 0;
    spans.push({
      kind: "attempt",
      title: `attempt ${attempt.attempt}${goesOn ? ", going on" : ""}`,
      outcome: attempt.outcome,
      start,
      end,
      device: attempt.device,
      passes: attempt.finished ? attempt.passes_done : job.passes_done,
      reason: attempt.reason,
    });
    at = end;
  });
  if (job.state === "queued") wait(Math.max(at, now), job.attempts.length === 0 ? "queued" : "queued again");
  else if (job.attempts.length === 0 && job.finished) wait(Date.parse(job.finished), "queued");
  return spans;
}
