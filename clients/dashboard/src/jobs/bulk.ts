// One thing done to many jobs: a few requests at a time, what failed kept, and stopped when asked.

import { sendJson } from "../api/client";
import type { JobState } from "../api/types";

export type BulkAction = { kind: "cancel" } | { kind: "retry" } | { kind: "purge" } | { kind: "priority"; priority: number };

/** The states in which the daemon does it; in others it would refuse. */
export function statesFor(action: BulkAction): JobState[] {
  switch (action.kind) {
    case "cancel":
    case "priority":
      return ["queued", "running"];
    case "retry":
      return ["failed", "cancelled"];
    case "purge":
      return ["queued", "running", "succeeded", "failed", "cancelled"];
  }
}

/** "Cancel", "Cancelled": as a button and as a report say it. */
export const kActionWords: Record<BulkAction["kind"], { verb: string; done: string }> = {
  cancel: { verb: "Cancel", done: "cancelled" },
  retry: { verb: "Retry", done: "queued again" },
  purge: { verb: "Remove", done: "removed" },
  priority: { verb: "Change the priority of", done: "given that priority" },
};

export function doTo(id: string, action: BulkAction): Promise<unknown> {
  const path = `/v1/jobs/${encodeURIComponent(id)}`;
  switch (action.kind) {
    case "cancel":
      return sendJson("DELETE", path);
    case "purge":
      return sendJson("DELETE", `${path}?purge=true`);
    case "retry":
      return sendJson("POST", `${path}/retry`);
    case "priority":
      return sendJson("PATCH", path, { priority: action.priority });
  }
}

export const clampPriority = (priority: number): number => Math.max(-100, Math.min(100, Math.round(priority)));
export const jobsText = (count: number): string => (count === 1 ? "1 job" : `${count.toLocaleString("en")} jobs`);

export interface BulkProgress {
  done: number;
  total: number;
  failures: { id: string; text: string }[];
}

const kAtOnce = 4;

/** Does it to every job, telling of progress after each. Ends early, without failure, when `stop` is aborted. */
export async function doToAll(
  ids: readonly string[],
  one: (id: string) => Promise<unknown>,
  tell: (progress: BulkProgress) => void,
  stop: AbortSignal,
): Promise<BulkProgress> {
  const progress: BulkProgress = { done: 0, total: ids.length, failures: [] };
  let next = 0;
  const work = async () => {
    while (next < ids.length && !stop.aborted) {
      const id = ids[next++]!;
      try {
        await one(id);
      } catch (failure) {
        progress.failures.push({ id, text: failure instanceof Error ? failure.message : String(failure) });
      }
      ++progress.done;
      tell({ ...progress });
    }
  };
  await Promise.all(Array.from({ length: Math.min(kAtOnce, ids.length) }, work));
  return { ...progress };
}
