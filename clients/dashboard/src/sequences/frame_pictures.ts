// The pictures of a sequence's frames, fetched one after the other as they come to be, so that playing waits for nothing.

import { useEffect, useMemo, useRef, useState } from "preact/hooks";

import { askPatiently } from "../api/client";
import type { SequenceFrame } from "../api/types";
import { HeldPictures } from "./held_pictures";

/** Pixels of a picture's longer side. */
const kSide = 640;
const kPauseMs = 2000;

export function useFramePictures(frames: SequenceFrame[]): HeldPictures {
  const { current: held } = useRef(new HeldPictures());
  const [, redraw] = useState(0);
  const ready = frames.filter((frame) => frame.state === "succeeded").map((frame) => frame.id);
  const wanted = ready.join(" ");
  useMemo(() => held.list(ready), [wanted]); // before it is drawn what is left out
  useEffect(() => {
    const stop = new AbortController();
    const fetchPicture = async (id: string) => {
      const answer = await askPatiently(`/v1/jobs/${id}/preview.png?max_size=${kSide}`, stop.signal);
      return answer.status === 200 ? answer.blob() : null;
    };
    const pause = () => new Promise<void>((goOn) => setTimeout(goOn, kPauseMs));
    void held.fetchMissing(fetchPicture, pause, () => redraw((round) => round + 1), stop.signal);
    return () => stop.abort();
  }, [wanted]);
  useEffect(() => () => held.list([]), []);
  return held;
}
