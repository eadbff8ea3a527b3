// A sequence, asked for again while its frames come.

import { useEffect, useMemo } from "preact/hooks";

import { listen } from "../api/events";
import { isOver, type Sequence, type SequenceSummary } from "../api/types";
import { useRemote, type Remote } from "../ui/remote";

const kAskAgainMs = 1000;
/** Frames are read again after as long as that takes for each of them, at least: a long list seldom. */
const kMsAFrame = 2;

/** Whether frames that were read some time ago are to be read again, now that the summary is this. */
export function areFramesDue(frames: SequenceSummary, now: SequenceSummary, count: number, msAgo: number): boolean {
  const same = JSON.stringify(frames.job_states) === JSON.stringify(now.job_states) && frames.state === now.state;
  return !same && (isOver(now.state) || msAgo >= kMsAFrame * count);
}

/** Its summary is asked for every second while anything happens, its frames where that tells of others. */
export function useSequence(id: string | null): Remote<Sequence> {
  const whole = useRemote<Sequence>(id ? `/v1/sequences/${id}` : null);
  const summary = useRemote<SequenceSummary>(id && whole.data && !isOver(whole.data.state) ? `/v1/sequences/${id}?frames=false` : null);
  const readAt = useMemo(() => Date.now(), [whole.data]);
  useEffect(() => {
    const { data } = whole;
    if (!data || isOver(data.state)) return;
    const now = summary.data;
    if (now && !whole.loading && areFramesDue(data, now, data.frames.length, Date.now() - readAt)) return whole.reload();
    let timer = 0;
    const soon = () => {
      if (!timer) timer = window.setTimeout(() => ((timer = 0), summary.reload()), kAskAgainMs);
    };
    const stop = listen((event) => event.type !== "status" && soon());
    soon();
    return () => {
      clearTimeout(timer);
      stop();
    };
  }, [whole.data, summary.data]);
  const data = useMemo(() => {
    const { data: all } = whole;
    return all && summary.data && !isOver(all.state) ? { ...all, ...summary.data } : all;
  }, [whole.data, summary.data]);
  return { ...whole, data };
}
