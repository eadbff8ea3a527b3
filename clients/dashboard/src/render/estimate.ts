// What the daemon says of a request before it is queued: what it would take, or what is wrong with it.

import { useEffect, useState } from "preact/hooks";

import { Problem, sendJson } from "../api/client";
import type { JobRequest, LeftOut } from "../api/types";

export interface Estimate {
  memory_bytes: number;
  device_memory_bytes: number | null;
  left_out: LeftOut[] | null;
  seconds: number | null;
  warnings: string[];
}

export interface Judgement {
  estimate: Estimate | null;
  problem: Problem | null;
  /** The daemon did not answer. */
  failure: Error | null;
  asking: boolean;
}

const kAfterTypingMs = 400;

export function useJudgement(request: JobRequest | null): Judgement {
  const [judgement, setJudgement] = useState<Judgement>({ estimate: null, problem: null, failure: null, asking: true });
  const text = request && JSON.stringify(request);
  useEffect(() => {
    if (!text) return;
    setJudgement((old) => ({ ...old, asking: true }));
    let gone = false;
    const timer = setTimeout(() => {
      sendJson<Estimate>("POST", "/v1/jobs?dry_run=true", JSON.parse(text)).then(
        (estimate) => gone || setJudgement({ estimate, problem: null, failure: null, asking: false }),
        (failure: Error) =>
          gone ||
          setJudgement(
            failure instanceof Problem
              ? { estimate: null, problem: failure, failure: null, asking: false }
              : { estimate: null, problem: null, failure, asking: false },
          ),
      );
    }, kAfterTypingMs);
    return () => {
      gone = true;
      clearTimeout(timer);
    };
  }, [text]);
  return judgement;
}
