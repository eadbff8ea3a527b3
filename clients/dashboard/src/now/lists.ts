// The lists of the start page, kept by events: what a change of a job does to them, and whether they must be read anew.

import { isOver, type JobChange, type JobSummary } from "../api/types";

export interface Lists {
  running: JobSummary[];
  /** The next to run, first first. */
  queue: JobSummary[];
  queued: number;
  /** Those that ended, the last first. */
  recent: JobSummary[];
  /** Jobs there have ever been, of any state. */
  total: number;
}

const kScalars = ["state", "progress", "passes_done", "seconds", "error_now", "started", "finished", "priority"] as const;

/** The row with what of the change it shows. */
export function changedRow(row: JobSummary, change: JobChange): JobSummary {
  const next: JobSummary = { ...row };
  for (const name of kScalars) if (name in change) Object.assign(next, { [name]: change[name] });
  if (change.failure !== undefined) next.failure = change.failure?.detail ?? null;
  return next;
}

/**
 * The lists after a change. `stale`: what they cannot tell by themselves has changed too, such as which job has come
 * into view at the end of a list, or all there is to say of one that is new.
 */
export function afterChange(lists: Lists, change: JobChange): { lists: Lists; stale: boolean } {
  const known = [...lists.running, ...lists.queue, ...lists.recent].find((row) => row.id === change.id);
  if (!known) return { lists, stale: change.state !== undefined || change.progress !== undefined };
  const row = changedRow(known, change);
  if (row.state === known.state) {
    const replaced = (rows: JobSummary[]) => (rows.includes(known) ? rows.map((old) => (old === known ? row : old)) : rows);
    return {
      lists: { ...lists, running: replaced(lists.running), queue: replaced(lists.queue), recent: replaced(lists.recent) },
      stale: row.priority !== known.priority,
    };
  }
  const without = (rows: JobSummary[]) => (rows.includes(known) ? rows.filter((old) => old !== known) : rows);
  const next = {
    ...lists,
    running: without(lists.running),
    queue: without(lists.queue),
    recent: without(lists.recent),
    queued: lists.queued + (row.state === "queued" ? 1 : 0) - (known.state === "queued" ? 1 : 0),
  };
  if (row.state === "running") next.running = [...next.running, row];
  else if (isOver(row.state)) next.recent = [row, ...next.recent];
  return { lists: next, stale: true };
}
