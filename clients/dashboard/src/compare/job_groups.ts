// Finished jobs that are worth a look beside each other: of one scene and one size.

import type { JobSummary } from "../api/types";

export interface JobGroup {
  key: string;
  scene: string;
  width: number;
  height: number;
  /** The newest first, but a reference before all. */
  jobs: JobSummary[];
}

/** Groups of two jobs or more, in the order of their newest one; at most `most` jobs each, of as many methods as there are. */
export function jobGroups(jobs: JobSummary[], most: number): JobGroup[] {
  const groups = new Map<string, JobGroup>();
  for (const job of jobs) {
    const key = `${job.scene} ${job.width} ${job.height}`;
    const group = groups.get(key) ?? { key, scene: job.scene, width: job.width, height: job.height, jobs: [] };
    group.jobs.push(job);
    groups.set(key, group);
  }
  return [...groups.values()].filter((group) => group.jobs.length > 1).map((group) => ({ ...group, jobs: chosen(group.jobs, most) }));
}

function chosen(jobs: JobSummary[], most: number): JobSummary[] {
  const reference = jobs.find((job) => job.role === "reference");
  const others = jobs.filter((job) => job !== reference);
  const newestOf = new Map<string, JobSummary>();
  for (const job of others) if (!newestOf.has(job.method)) newestOf.set(job.method, job);
  const firsts = new Set(newestOf.values());
  const inTurn = [...others.filter((job) => firsts.has(job)), ...others.filter((job) => !firsts.has(job))];
  return [...(reference ? [reference] : []), ...inTurn].slice(0, most);
}
