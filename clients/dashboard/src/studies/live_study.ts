// A comparison's report, kept up while its jobs run: what events tell of single jobs at once, the report itself again
// when they have told enough.

import { useEffect, useMemo, useRef, useState } from "preact/hooks";

import { listen } from "../api/events";
import { isOver, type ComparisonReport, type JobState } from "../api/types";
import { useRemote, type Remote } from "../ui/remote";
import { awaitsBias } from "./bias";
import { referenceJobs } from "./series";

/** The least time between two reports of a comparison that runs. */
const kBetweenMs = 2000;
const kSoonMs = 150;
/** Bias is measured after the jobs, and never where a film is lost: it is asked for this often, and this many times. */
const kBiasMs = 3000;
const kBiasTries = 20;

export interface LiveJob {
  state: JobState;
  progress: number;
  passes: number;
  seconds: number;
}

export interface LiveStudy extends Remote<ComparisonReport> {
  /** By job; the reference's too. */
  jobs: ReadonlyMap<string, LiveJob>;
}

export function useLiveStudy(id: string): LiveStudy {
  const remote = useRemote<ComparisonReport>(`/v1/comparisons/${id}/report.json`);
  const [told, setTold] = useState<Map<string, Partial<LiveJob>>>(new Map());
  const ids = useRef(new Set<string>());
  const running = useRef(true);
  useEffect(() => {
    if (!remote.data) return;
    ids.current = new Set([...remote.data.jobs.flatMap((job) => job.runs.map((run) => run.id)), ...referenceJobs(remote.data)]);
    running.current = !isOver(remote.data.state);
  }, [remote.data]);

  useEffect(() => {
    let timer = 0;
    let last = performance.now();
    const again = (delay: number) => {
      clearTimeout(timer);
      timer = window.setTimeout(() => {
        last = performance.now();
        timer = 0;
        remote.reload();
      }, delay);
    };
    const stop = listen((event) => {
      if (event.type === "gap") return again(kSoonMs);
      if (event.type === "status") return;
      const { change } = event;
      if (!ids.current.has(change.id)) return;
      setTold((old) => {
        const next = new Map(old);
        const known = { ...next.get(change.id) };
        if (change.state) known.state = change.state;
        if (change.progress !== undefined) known.progress = change.progress;
        if (change.passes_done !== undefined) known.passes = change.passes_done;
        if (change.seconds !== undefined) known.seconds = change.seconds;
        return next.set(change.id, known);
      });
      if (event.type === "state") again(kSoonMs);
      else if (!timer && running.current) again(Math.max(kSoonMs, last + kBetweenMs - performance.now()));
    });
    return () => {
      clearTimeout(timer);
      stop();
    };
  }, [remote.reload]);

  const awaited = remote.data !== null && awaitsBias(remote.data);
  useEffect(() => {
    if (!awaited) return;
    let tries = 0;
    const timer = setInterval(() => (++tries > kBiasTries ? clearInterval(timer) : remote.reload()), kBiasMs);
    return () => clearInterval(timer);
  }, [awaited, remote.reload]);

  const jobs = useMemo(() => {
    const found = new Map<string, LiveJob>();
    for (const job of remote.data?.jobs ?? []) {
      const over = isOver(job.state);
      const read: LiveJob = { state: job.state, progress: over ? 1 : 0, passes: job.passes_done, seconds: job.seconds };
      found.set(job.id, over ? read : { ...read, ...told.get(job.id) });
      for (const run of job.runs) {
        if (run.id === job.id) continue;
        const unread: LiveJob = { state: run.state, progress: isOver(run.state) ? 1 : 0, passes: 0, seconds: 0 };
        found.set(run.id, { ...unread, ...told.get(run.id) });
      }
    }
    const reference = remote.data?.reference;
    if (remote.data && reference?.state) {
      const over = isOver(reference.state);
      const read: LiveJob = { state: reference.state, progress: over ? 1 : 0, passes: 0, seconds: 0 };
      for (const job of referenceJobs(remote.data)) found.set(job, over ? read : { ...read, ...told.get(job) });
    }
    return found;
  }, [remote.data, told]);
  return { ...remote, jobs };
}
