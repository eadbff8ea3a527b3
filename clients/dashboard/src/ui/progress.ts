// How far a job is, and how long it will go on.

import { percentText, secondsText } from "./format";

export interface Progress {
  /** 0..1 */
  progress: number;
  /** Of rendering so far. */
  seconds: number;
}

/** Seconds until the job is over, by how far it has come in the time it took; null where nothing can be told. */
export function secondsLeft(job: Progress): number | null {
  if (!(job.progress > 0) || !(job.seconds > 0)) return null;
  return (job.seconds * (1 - job.progress)) / job.progress;
}

/** "25 %, about 42 s left" */
export function progressText(job: Progress): string {
  const left = secondsLeft(job);
  return percentText(job.progress) + (left !== null && job.progress < 1 ? `, about ${secondsText(left)} left` : "");
}

/** "2 passes in 14.1 s" */
export const passesText = (passes: number, seconds: number): string =>
  `${passes.toLocaleString("en")} ${passes === 1 ? "pass" : "passes"} in ${secondsText(seconds)}`;
