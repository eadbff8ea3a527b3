// Where the list's rows come from: pages of summaries, or the very jobs that were asked for by name.

import { getJson, Problem, withQuery } from "../api/client";
import type { Job, JobState, JobSummary, JobSummaryPage } from "../api/types";
import { daemonQuery, matches, type Filter } from "./filter";
import type { FetchPage } from "./job_list";

const kLargestPage = 1000;

export const summaryOf = (job: Job): JobSummary => ({
  ...(job as unknown as JobSummary), // what both have; a summary has it in the same words
  scene: job.request.scene,
  method: job.request.method.name,
  device: job.request.method.device,
  width: job.request.image.width,
  height: job.request.image.height,
  priority: job.request.priority,
  labels: job.request.labels,
  failure: job.failure?.detail ?? null,
});

async function namedJobs(filter: Filter, signal: AbortSignal): Promise<JobSummary[]> {
  const found = await Promise.all(
    filter.ids.map((id) =>
      getJson<Job>(`/v1/jobs/${id}`, {}, signal).then(summaryOf, (failure: Error) => {
        if (failure instanceof Problem && failure.status === 404) return null;
        throw failure;
      }),
    ),
  );
  return found.filter((job): job is JobSummary => job !== null && matches(filter, job));
}

export function pagesOf(filter: Filter): FetchPage {
  return async (offset, limit, signal) => {
    if (filter.ids.length > 0) {
      const jobs = await namedJobs(filter, signal);
      return { items: jobs.slice(offset, offset + limit), next_cursor: null, total: jobs.length };
    }
    return getJson<JobSummaryPage>("/v1/jobs", { view: "summary", ...daemonQuery(filter), offset: offset || null, limit }, signal);
  };
}

export async function countOf(filter: Filter, signal: AbortSignal): Promise<number> {
  return (await pagesOf(filter)(0, 1, signal)).total;
}

/** Every job that matches and is in one of the states, page by page; jobs that come meanwhile are not among them. */
export async function allJobs(
  filter: Filter,
  states: JobState[],
  tell: (count: number) => void,
  signal: AbortSignal,
): Promise<JobSummary[]> {
  if (filter.ids.length > 0) return (await namedJobs(filter, signal)).filter((job) => states.includes(job.state));
  const found: JobSummary[] = [];
  for (let cursor: string | null = ""; cursor !== null; ) {
    const path = withQuery("/v1/jobs", { view: "summary", ...daemonQuery({ ...filter, states }), limit: kLargestPage, cursor });
    const page: JobSummaryPage = await getJson<JobSummaryPage>(path, {}, signal);
    found.push(...page.items);
    cursor = page.next_cursor;
    tell(found.length);
  }
  return found;
}

/** The states both the filter and an action are about. */
export const statesBoth = (filter: Filter, states: JobState[]): JobState[] =>
  filter.states.length === 0 ? states : states.filter((state) => filter.states.includes(state));
