// The job's log, as the daemon writes it.

import { useEffect, useRef, useState } from "preact/hooks";

import { ask } from "../api/client";
import { isOver, type Job } from "../api/types";

const kEveryMs = 3000;

export function Log({ job }: { job: Job }) {
  const [text, setText] = useState<string | null>(null);
  const [failure, setFailure] = useState("");
  const box = useRef<HTMLPreElement>(null);
  const atEnd = useRef(true);
  useEffect(() => {
    const stop = new AbortController();
    const read = async () => {
      try {
        const answer = await ask(`/v1/jobs/${job.id}/log.txt`, { signal: stop.signal, cache: "no-cache" });
        setText(answer.status === 202 ? "" : await answer.text());
        setFailure("");
      } catch (fault) {
        if (!stop.signal.aborted) setFailure((fault as Error).message);
      }
    };
    void read();
    const timer = isOver(job.state) ? 0 : window.setInterval(() => document.hidden || void read(), kEveryMs);
    return () => {
      stop.abort();
      clearInterval(timer);
    };
  }, [job.id, job.state, job.attempts.length]);
  // Who reads the end sees what comes; who has scrolled up is left there.
  useEffect(() => {
    if (atEnd.current && box.current) box.current.scrollTop = box.current.scrollHeight;
  }, [text]);
  if (failure) return <p class="notice failed">{failure}</p>;
  return (
    <pre
      ref={box}
      class="job-code job-log"
      tabIndex={0}
      aria-label="Log"
      onScroll={(event) => {
        const { scrollTop, scrollHeight, clientHeight } = event.currentTarget;
        atEnd.current = scrollTop + clientHeight >= scrollHeight - 8;
      }}
    >
      {text === null ? "Loading …" : text || "Nothing yet."}
    </pre>
  );
}
