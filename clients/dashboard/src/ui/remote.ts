// Data of the daemon in a component: asked for when the path changes, and again on demand.

import { useCallback, useEffect, useRef, useState } from "preact/hooks";

import { askPatiently, getJson, Problem } from "../api/client";

export interface Remote<T> {
  /** What was read last; kept while it is asked for again. */
  data: T | null;
  failure: Error | null;
  loading: boolean;
  /** Asks again. */
  reload: () => void;
  /** Changes what is held, such as by an event. */
  patch: (change: (data: T) => T) => void;
}

/** What is at a path; nothing for null. `patient`: where it waits for a job that renders it is asked for again. */
export function useRemote<T>(path: string | null, patient = false): Remote<T> {
  const [state, setState] = useState<{ path: string | null; data: T | null; failure: Error | null; loading: boolean }>({
    path,
    data: null,
    failure: null,
    loading: path !== null,
  });
  const [round, setRound] = useState(0);
  useEffect(() => {
    if (path === null) return setState({ path, data: null, failure: null, loading: false });
    const stop = new AbortController();
    setState((old) => ({ path, data: old.path === path ? old.data : null, failure: null, loading: true }));
    const answer = patient ? askPatiently(path, stop.signal).then((found) => found.json() as Promise<T>) : getJson<T>(path, {}, stop.signal);
    answer.then(
      (data) => setState({ path, data, failure: null, loading: false }),
      (failure: Error) => {
        if (!stop.signal.aborted) setState((old) => ({ ...old, failure, loading: false }));
      },
    );
    return () => stop.abort();
  }, [path, round]);
  const reload = useCallback(() => setRound((old) => old + 1), []);
  const patch = useCallback(
    (change: (data: T) => T) => setState((old) => (old.data === null ? old : { ...old, data: change(old.data) })),
    [],
  );
  const current = state.path === path;
  return { data: current ? state.data : null, failure: state.failure, loading: !current || state.loading, reload, patch };
}

export interface BlobImage {
  url: string | null;
  failure: Problem | Error | null;
}

/**
 * A picture of the daemon as a URL for <img>: an <img> itself could not carry the token. `version` asks again (the old
 * picture stays until the new one is there). 202, nothing rendered yet, is no picture and no failure.
 */
export function useImage(path: string | null, version: string | number = 0): BlobImage {
  const [state, setState] = useState<BlobImage>({ url: null, failure: null });
  const shown = useRef<string | null>(null);
  const shownPath = useRef(path);
  useEffect(() => {
    const stop = new AbortController();
    const replace = (url: string | null, failure: Error | null) => {
      if (shown.current) URL.revokeObjectURL(shown.current);
      shown.current = url;
      setState({ url, failure });
    };
    if (shownPath.current !== path) replace(null, null);
    shownPath.current = path;
    if (path === null) return;
    askPatiently(path, stop.signal)
      .then((answer) => (answer.status === 202 ? null : answer.blob()))
      .then(
        (blob) => {
          if (blob && !stop.signal.aborted) replace(URL.createObjectURL(blob), null);
        },
        (failure: Error) => {
          if (!stop.signal.aborted) replace(null, failure);
        },
      );
    return () => stop.abort();
  }, [path, version]);
  useEffect(
    () => () => {
      if (shown.current) URL.revokeObjectURL(shown.current);
    },
    [],
  );
  return state;
}
