// The last minutes of what the daemon gets done: as the jobs tell that there are when the page is opened, and from then on
// by its status events, whichever room is shown.

import { signal } from "@preact/signals";

import { getJson } from "../api/client";
import { listen } from "../api/events";
import type { JobSummaryPage } from "../api/types";
import { type Sample, sampleOf, samplesBefore, withSample } from "./rates";

const kJobsLookedAt = 200;

export const samples = signal<Sample[]>([]);

async function lookBack(first: Sample): Promise<void> {
  const page = (query: Record<string, string | number>) => getJson<JobSummaryPage>("/v1/jobs", { view: "summary", limit: kJobsLookedAt, ...query });
  const [ended, running] = await Promise.all([page({ order: "ended" }), page({ state: "running" })]);
  const now = samples.peek();
  if (now[0]?.at === first.at) samples.value = [...samplesBefore(first, [...ended.items, ...running.items], Date.now()), ...now];
}

listen((event) => {
  if (event.type !== "status") return;
  const now = withSample(samples.peek(), sampleOf(event.status));
  samples.value = now;
  if (now.length === 1) lookBack(now[0]!).catch(() => undefined); // without it the charts begin now
});
