// All scenes of a list, page after page, shown as they come: a daemon that has just begun reads its built-in ones now.

import { useEffect, useState } from "preact/hooks";

import { getJson } from "../api/client";
import type { Page, Scene } from "../api/types";

const kPage = 8;

export interface AllScenes {
  scenes: Scene[];
  /** Whether more are to come. */
  loading: boolean;
  failure: Error | null;
}

/** Those of a family, or where it is empty the uploaded ones, newest first, and then the built-in ones. `round`: again. */
export function useAllScenes(family: string, round: number): AllScenes {
  const [state, setState] = useState<AllScenes & { family: string }>({ family, scenes: [], loading: true, failure: null });
  useEffect(() => {
    const stop = new AbortController();
    const read = async () => {
      const scenes: Scene[] = [];
      let cursor: string | null = null;
      do {
        const page: Page<Scene> = await getJson("/v1/scenes", { family, limit: kPage, cursor }, stop.signal);
        scenes.push(...page.items);
        cursor = page.next_cursor;
        // Read again, the list is shown as it was until it has come whole.
        const shown = [...scenes];
        const loading = cursor !== null;
        setState((old) => (loading && old.family === family && old.scenes.length > shown.length ? old : { family, scenes: shown, loading, failure: null }));
      } while (cursor !== null);
    };
    setState((old) => (old.family === family ? { ...old, loading: true, failure: null } : { family, scenes: [], loading: true, failure: null }));
    read().catch((failure: Error) => {
      if (!stop.signal.aborted) setState((old) => ({ ...old, loading: false, failure }));
    });
    return () => stop.abort();
  }, [family, round]);
  return state.family === family ? state : { scenes: [], loading: true, failure: null };
}
