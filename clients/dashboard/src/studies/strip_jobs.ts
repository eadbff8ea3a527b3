// Pictures of all entries at one error or at one time: which jobs give them. A comparison keeps the films of its jobs'
// ends alone, so that anything else is rendered for it, by the same request with another stop.

import type { ComparisonReport, JobRequest, JobSummary, StopConditions } from "../api/types";
import { referenceJobs, rowName } from "./series";

export type StripAt = { kind: "end" } | { kind: "error"; metric: string; error: number } | { kind: "time"; seconds: number };

/** In the address: "error 0.01" or "time 2"; the end where it says nothing else. */
export function readStrip(text: string | undefined, metric: string): StripAt {
  const [kind, level] = (text ?? "").split(" ");
  const value = Number(level);
  if (!(value > 0)) return { kind: "end" };
  return kind === "error" ? { kind, metric, error: value } : kind === "time" ? { kind, seconds: value } : { kind: "end" };
}

export const stripText = (at: StripAt): string => (at.kind === "end" ? "" : at.kind === "error" ? `error ${at.error}` : `time ${at.seconds}`);

const kStripLabel = "strip";
const kEntryLabel = "entry";

/** What all jobs of a strip are found again by. */
export const stripName = (study: string, at: StripAt): string =>
  at.kind === "error" ? `${study} ${at.metric} ${at.error}` : at.kind === "time" ? `${study} seconds ${at.seconds}` : study;
export const stripFilter = (study: string, at: StripAt): string => `${kStripLabel}=${stripName(study, at)}`;

/** A target may be missed by an unlucky seed: such a job ends after this many times what the comparison took. */
const kPatience = 4;
const kLeastPatienceSeconds = 5;

function stopFor(report: ComparisonReport, row: number, at: StripAt): StopConditions | null {
  if (at.kind === "time") return { seconds: at.seconds };
  if (at.kind === "end") return null;
  const reached = report.table[row]!.time_to_error[at.metric]?.find((level) => level.error === at.error)?.seconds;
  if (!reached) return null;
  return { target: { metric: at.metric, value: at.error }, seconds: Math.max(kLeastPatienceSeconds, kPatience * reached) };
}

/** One request a row, of its first seed; null for a row that never got there. */
export function stripRequests(report: ComparisonReport, at: StripAt): (JobRequest | null)[] {
  const { request } = report;
  return report.table.map((row, index) => {
    const stop = stopFor(report, index, at);
    const entry = request.entries.find((other) => (other.label ?? other.method.name) === row.label);
    if (!stop || !entry) return null;
    const { entries: _, seeds, stop: __, labels, title: _title, notes: _notes, ...shared } = request;
    // One film by its name; two are found again by what they were asked for as.
    const films = referenceJobs(report);
    const reference = films.length === 1 ? `job:${films[0]}` : request.reference;
    // What the comparison measures is asked for again, but for what needs no asking: estimates.
    const metrics = request.metrics.filter((metric) => !metric.endsWith("estimated_relative_mse"));
    const job: Record<string, unknown> = {
      ...shared,
      scene: request.scene,
      image: request.image,
      metrics,
      reference,
      method: { ...entry.method, parameters: { ...entry.method.parameters, ...row.parameters } },
      stop,
      seed: seeds[0]!,
      labels: { ...(labels as Record<string, string> | undefined), [kStripLabel]: stripName(report.id, at), [kEntryLabel]: rowName(row) },
    };
    return job as JobRequest;
  });
}

/** The newest job of each row among those that the filter found. */
export const stripJobs = (report: ComparisonReport, found: JobSummary[]): (JobSummary | null)[] =>
  report.table.map((row) => found.find((job) => job.labels[kEntryLabel] === rowName(row)) ?? null);
