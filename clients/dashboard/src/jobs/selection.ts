// What of the list is picked: single jobs, kept with what was known of them, or all that match the filter.

import type { JobSummary } from "../api/types";

export interface Selection {
  /** All that match, however many; `jobs` is then empty. */
  all: boolean;
  jobs: ReadonlyMap<string, JobSummary>;
}

export const kNothing: Selection = { all: false, jobs: new Map() };

export const isSelected = (selection: Selection, job: JobSummary | undefined): boolean =>
  job !== undefined && (selection.all || selection.jobs.has(job.id));

/** One more or one less. Of "all" there is no less: it becomes the one that was meant. */
export function toggled(selection: Selection, job: JobSummary): Selection {
  if (selection.all) return { all: false, jobs: new Map([[job.id, job]]) };
  const jobs = new Map(selection.jobs);
  if (!jobs.delete(job.id)) jobs.set(job.id, job);
  return { all: false, jobs };
}

export function withJobs(selection: Selection, added: JobSummary[]): Selection {
  const jobs = new Map(selection.all ? [] : selection.jobs);
  for (const job of added) jobs.set(job.id, job);
  return { all: false, jobs };
}

/** Keeps what is known of picked jobs as new as the list's own rows. */
export function renewed(selection: Selection, row: (id: string) => JobSummary | undefined): Selection {
  let changed = false;
  const jobs = new Map<string, JobSummary>();
  for (const [id, job] of selection.jobs) {
    const now = row(id) ?? job;
    changed ||= now !== job;
    jobs.set(id, now);
  }
  return changed ? { all: false, jobs } : selection;
}
