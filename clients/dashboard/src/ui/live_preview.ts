// The picture of a job that is being rendered: a new one for new passes, but no faster than the daemon makes them and no
// more often than a person needs.

import { useEffect, useRef, useState } from "preact/hooks";

import { askPatiently } from "../api/client";
import type { BlobImage } from "./remote";

const kBetweenMs = 2000;

/** The picture at a path, asked for again when `version` has changed: one request at a time, 2 s at least between them. */
export function useLivePreview(path: string, version: number): BlobImage {
  const [state, setState] = useState<BlobImage>({ url: null, failure: null });
  const wanted = useRef(version);
  const kick = useRef(() => {});
  useEffect(() => {
    const stop = new AbortController();
    let shown: string | null = null;
    let loaded = Number.NaN;
    let busy = false;
    let timer = 0;
    let begun = -Infinity;
    const show = (url: string | null, failure: Error | null) => {
      if (shown) URL.revokeObjectURL(shown);
      shown = url;
      setState({ url, failure });
    };
    const load = async () => {
      timer = 0;
      busy = true;
      begun = performance.now();
      const asked = wanted.current;
      try {
        const answer = await askPatiently(path, stop.signal);
        const blob = answer.status === 202 ? null : await answer.blob();
        if (stop.signal.aborted) return;
        if (blob) show(URL.createObjectURL(blob), null);
      } catch (failure) {
        if (stop.signal.aborted) return;
        if (!shown) setState({ url: null, failure: failure as Error });
      }
      loaded = asked;
      busy = false;
      plan();
    };
    const plan = () => {
      if (busy || timer || stop.signal.aborted || loaded === wanted.current) return;
      timer = window.setTimeout(() => void load(), Math.max(0, begun + kBetweenMs - performance.now()));
    };
    kick.current = plan;
    plan();
    return () => {
      stop.abort();
      clearTimeout(timer);
      if (shown) URL.revokeObjectURL(shown);
      setState({ url: null, failure: null });
    };
  }, [path]);
  useEffect(() => {
    wanted.current = version;
    kick.current();
  }, [version]);
  return state;
}
