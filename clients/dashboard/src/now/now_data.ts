// The start page's lists: read once, kept by events, and read again when an event has changed what they cannot tell
// themselves. Nothing is asked by the clock.

import { useCallback, useEffect, useRef, useState } from "preact/hooks";

import { getJson } from "../api/client";
import { connection, listen } from "../api/events";
import type { JobSummaryPage } from "../api/types";
import { afterChange, type Lists } from "./lists";

export const kQueueShown = 8;
export const kRecentShown = 12;
const kBetweenMs = 1000;

async function readLists(signal: AbortSignal): Promise<Lists> {
  const page = (query: Record<string, string | number>) => getJson<JobSummaryPage>("/v1/jobs", { view: "summary", ...query }, signal);
  const [running, queue, recent] = await Promise.all([
    page({ state: "running" }),
    page({ order: "queue", limit: kQueueShown }),
    page({ order: "ended", limit: kRecentShown }),
  ]);
  return {
    running: running.items.reverse(),
    queue: queue.items,
    queued: queue.total,
    recent: recent.items,
    total: running.total + queue.total + recent.total,
  };
}

export interface NowData {
  lists: Lists | null;
  failure: Error | null;
  reload: () => void;
}

export function useNowData(): NowData {
  const [lists, setLists] = useState<Lists | null>(null);
  const [failure, setFailure] = useState<Error | null>(null);
  const reader = useRef<() => void>(() => {});
  useEffect(() => {
    const stop = new AbortController();
    let held: Lists | null = null;
    let reading = false;
    let again = false;
    let timer = 0;
    let begun = -Infinity;
    const hold = (next: Lists) => setLists((held = next));
    const read = async () => {
      timer = 0;
      reading = true;
      again = false;
      begun = performance.now();
      try {
        hold(await readLists(stop.signal));
        setFailure(null);
      } catch (reason) {
        if (stop.signal.aborted) return;
        setFailure(reason as Error);
      }
      reading = false;
      if (again) plan();
    };
    // What has happened while the lists were read may be in them or not: they are read once more.
    const plan = () => {
      if (reading) again = true;
      else timer ||= window.setTimeout(() => void read(), Math.max(0, begun + kBetweenMs - performance.now()));
    };
    reader.current = plan;
    void read();
    const unlisten = listen((event) => {
      // While the daemon does not answer there is nothing to ask; it is done when it does again (below).
      if (event.type === "gap") return connection.peek() === "lost" ? undefined : plan();
      if (event.type === "status") return;
      if (!held) return plan();
      const after = afterChange(held, event.change);
      if (after.lists !== held) hold(after.lists);
      if (after.stale) plan();
    });
    let was = connection.peek();
    const unwatch = connection.subscribe((now) => {
      if (was === "lost" && now === "live") plan();
      was = now;
    });
    return () => {
      stop.abort();
      clearTimeout(timer);
      unlisten();
      unwatch();
    };
  }, []);
  return { lists, failure, reload: useCallback(() => reader.current(), []) };
}
