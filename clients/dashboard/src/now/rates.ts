// What the daemon gets done in a second, from the totals that its status events bring: by the daemon's own clock, so
// that neither the network nor a page that was not looked at distorts it.

import type { DaemonStatus } from "../api/types";

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

/** For each sample how much a second there was over the window that ends with it; null for the first. */
export function rates(samples: Sample[], quantity: Quantity, windowSeconds: number): (number | null)[] {
  let first = 0;
  return samples.map((sample, index) => {
    // Totals may be taken back, as when an attempt is lost; a rate is never below nothing.
    while (first + 1 < index && samples[first + 1]!.at <= sample.at - windowSeconds) ++first;
    const begin = samples[first]!;
    return index === 0 ? null : Math.max(0, sample[quantity] - begin[quantity]) / (sample.at - begin.at);
  });
}
