// The last minutes of what the daemon gets done: by its status events, whichever room is shown, and before the first of
// those as the jobs tell.

import { signal } from "@preact/signals";

import { getJson } from "../api/client";
import { listen } from "../api/events";
import type { JobSummaryPage } from "../api/types";
import { type Sample, sampleOf, samplesBefore, withSample } from "./rates";

const kJobsLookedAt = 200;

export const samples = signal<Sample[]>([]);

let lookedBack = false;

/** Once in a page's life, when somebody looks at the charts: puts what was before the first sample in front of it. */
export async function lookBack(first: Sample): Promise<void> {
  if (lookedBack) return;
  lookedBack = true;
  const page = (query: Record<string, string | number>) => getJson<JobSummaryPage>("/v1/jobs", { view: "summary", limit: kJobsLookedAt, ...query });
  const [ended, running] = await Promise.all([page({ order: "ended" }), page({ state: "running" })]);
  const now = samples.peek();
  if (now[0]?.at === first.at) samples.value = [...samplesBefore(first, [...ended.items, ...running.items], Date.now()), ...now];
}

listen((event) => {
  if (event.type !== "status") return;
  samples.value = withSample(samples.peek(), sampleOf(event.status));
});
