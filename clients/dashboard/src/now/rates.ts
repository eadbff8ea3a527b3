// What the daemon gets done in a second, from the totals that its status events bring: by the daemon's own clock, so
// that neither the network nor a page that was not looked at distorts it.

import type { DaemonStatus, JobSummary } from "../api/types";

/** Of what is not known of a moment, NaN. */
export interface Sample {
  /** Seconds since the daemon started. */
  at: number;
  passes: number;
  rays: number;
  photons: number;
  jobs: number;
  /** Resident bytes of the daemon and all its processes. */
  memory: number;
}

export type Quantity = Exclude<keyof Sample, "at" | "memory">;

const kKeptSeconds = 300;
const kBackSeconds = 5;

export function sampleOf(status: DaemonStatus): Sample {
  const sum = (values: (number | null)[]) => values.reduce<number>((total, value) => total + (value ?? 0), 0);
  return {
    at: status.uptime_seconds,
    passes: status.totals.passes,
    rays: sum(Object.values(status.totals.rays)),
    photons: status.totals.photons,
    jobs: sum(Object.values(status.totals.jobs)),
    memory: sum([status.resident_bytes, ...status.workers.map((worker) => worker.resident_bytes)]),
  };
}

/** The samples with one more; those of a daemon that has been started anew begin afresh, and old ones go. */
export function withSample(samples: Sample[], sample: Sample): Sample[] {
  const last = samples.at(-1);
  if (last && sample.at === last.at) return samples;
  if (last && sample.at < last.at) return [sample];
  return [...samples.filter((old) => old.at >= sample.at - kKeptSeconds), sample];
}

type Rendered = Pick<JobSummary, "started" | "finished" | "passes_done">;

/**
 * What there was before the first sample, by the jobs that have ended since or run: their passes are spread over the time that
 * they ran. Of rays, photons and memory they tell nothing. `now`: when the sample was taken, in milliseconds.
 */
export function samplesBefore(first: Sample, jobs: readonly Rendered[], now: number): Sample[] {
  const spans = jobs.flatMap((job) => {
    const end = job.finished ? (Date.parse(job.finished) - now) / 1000 : 0;
    return job.started ? [{ start: (Date.parse(job.started) - now) / 1000, end, over: job.finished !== null, passes: job.passes_done }] : [];
  });
  const samples: Sample[] = [];
  for (let ago = Math.min(kKeptSeconds, Math.floor(first.at / kBackSeconds) * kBackSeconds); ago > 0; ago -= kBackSeconds) {
    const sample = { ...first, at: first.at - ago, rays: NaN, photons: NaN, memory: NaN };
    for (const { start, end, over, passes } of spans) {
      if (end <= -ago) continue;
      sample.passes -= passes * Math.min(1, (end + ago) / Math.max(end - start, 1e-3));
      if (over) --sample.jobs;
    }
    samples.push(sample);
  }
  return samples;
}

/** For each sample how much a second there was over the window that ends with it; null for the first, and where it is not known. */
export function rates(samples: Sample[], quantity: Quantity, windowSeconds: number): (number | null)[] {
  let first = 0;
  return samples.map((sample, index) => {
    // Totals may be taken back, as when an attempt is lost; a rate is never below nothing.
    while (first + 1 < index && (Number.isNaN(samples[first]![quantity]) || samples[first + 1]!.at <= sample.at - windowSeconds)) ++first;
    const begin = samples[first]!;
    const gained = sample[quantity] - begin[quantity];
    return index === 0 || Number.isNaN(gained) ? null : Math.max(0, gained) / (sample.at - begin.at);
  });
}
