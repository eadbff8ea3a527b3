// The pictures of a sequence's frames, fetched one after the other as they come to be, so that playing waits for nothing.

import { useEffect, useRef, useState } from "preact/hooks";

import { askPatiently } from "../api/client";
import type { SequenceFrame } from "../api/types";

/** Pixels of a picture's longer side. */
const kSide = 640;
/** Of one sequence: what a page can hold. */
export const kMostPictures = 1000;

/** URLs for <img> by the frame's job. */
export function useFramePictures(frames: SequenceFrame[]): Map<string, string> {
  const held = useRef(new Map<string, string>());
  const [, redraw] = useState(0);
  const ready = frames.filter((frame) => frame.state === "succeeded").slice(0, kMostPictures);
  const wanted = ready.map((frame) => frame.id).join(" ");
  useEffect(() => {
    const stop = new AbortController();
    const fetchAll = async () => {
      for (const { id } of ready) {
        if (held.current.has(id)) continue;
        try {
          const answer = await askPatiently(`/v1/jobs/${id}/preview.png?max_size=${kSide}`, { signal: stop.signal });
          if (answer.status === 200) held.current.set(id, URL.createObjectURL(await answer.blob()));
          redraw((round) => round + 1);
        } catch {
          if (stop.signal.aborted) return;  // another list, or nobody looks any more
        }
      }
    };
    void fetchAll();
    return () => stop.abort();
  }, [wanted]);
  useEffect(
    () => () => {
      for (const url of held.current.values()) URL.revokeObjectURL(url);
    },
    [],
  );
  return held.current;
}
