// The list of jobs of a filter, kept as the daemon's events say, and how many jobs are in each state.

import { useEffect, useMemo, useState } from "preact/hooks";

import { getJson } from "../api/client";
import { listen } from "../api/events";
import { kJobStates, type Device, type JobState, type Method, type Page, type Scene } from "../api/types";
import { filterText, type Filter, type Vocabulary } from "./filter";
import { JobList } from "./job_list";
import { countOf, pagesOf } from "./source";

const kRefreshMs = 1000;
const kCountMs = 2000;

/** Calls what is asked for, soon but not more often than that. */
function throttled(run: () => unknown, everyMs: number): { ask: () => void; stop: () => void } {
  let timer = 0;
  let last = -Infinity;
  return {
    ask: () => {
      timer ||= window.setTimeout(() => {
        timer = 0;
        last = performance.now();
        run();
      }, Math.max(50, last + everyMs - performance.now()));
    },
    stop: () => clearTimeout(timer),
  };
}

export function useJobList(filter: Filter): JobList {
  const key = filterText(filter);
  const list = useMemo(() => new JobList(pagesOf(filter)), [key]);
  useEffect(() => {
    const refresh = throttled(() => list.refresh(), kRefreshMs);
    const ignore = listen((event) => {
      if (event.type === "gap") return refresh.ask();
      if (event.type === "status") {
        // The daemon answers again.
        if (list.failure) refresh.ask();
        return;
      }
      const known = list.patch(event.change);
      // A job that is new, or one that by its new state may belong here or no longer.
      if (event.type === "state" && (!known || (filter.states.length > 0 && !filter.states.includes(event.change.state!)))) refresh.ask();
    });
    return () => {
      ignore();
      refresh.stop();
      list.close();
    };
  }, [list]);
  return list;
}

/** How many jobs are in each state, of those that match the filter's other words. */
export function useStateCounts(filter: Filter): Partial<Record<JobState, number>> {
  const key = filterText({ ...filter, states: [] });
  const [counts, setCounts] = useState<Partial<Record<JobState, number>>>({});
  useEffect(() => {
    const stop = new AbortController();
    const count = () => {
      if (document.hidden) return;
      for (const state of kJobStates)
        countOf({ ...filter, states: [state] }, stop.signal).then(
          (total) => setCounts((old) => (old[state] === total ? old : { ...old, [state]: total })),
          () => {}, // the list itself says that the daemon does not answer
        );
    };
    count();
    const again = throttled(count, kCountMs);
    const ignore = listen((event) => {
      if (event.type === "state" || event.type === "gap") again.ask();
    });
    return () => {
      stop.abort();
      ignore();
      again.stop();
    };
  }, [key]);
  return counts;
}

/** Names to fill in; labels are those of the rows that have been seen. */
export function useVocabulary(list: JobList): Vocabulary {
  const [names, setNames] = useState<Omit<Vocabulary, "labels">>({ methods: [], scenes: [], devices: [] });
  useEffect(() => {
    const stop = new AbortController();
    const ask = <T,>(path: string) => getJson<Page<T>>(path, { limit: 1000 }, stop.signal);
    Promise.all([ask<Method>("/v1/methods"), ask<Scene>("/v1/scenes"), getJson<Page<Device>>("/v1/devices", {}, stop.signal)]).then(
      ([methods, scenes, devices]) =>
        setNames({
          methods: methods.items.map(({ name }) => name),
          scenes: scenes.items.map(({ name }) => name),
          devices: devices.items.map(({ id }) => id),
        }),
      () => {}, // suggestions are a help, no more
    );
    return () => stop.abort();
  }, []);
  return {
    ...names,
    get labels() {
      const labels = new Set<string>();
      for (const job of list.loaded()) for (const [key, value] of Object.entries(job.labels)) labels.add(`${key}=${value}`);
      return [...labels].sort();
    },
  };
}
