// Before many jobs are changed: how many, and which are left as they are. Then how far it has come, and what failed.

import { useEffect, useRef, useState } from "preact/hooks";

import type { JobSummary } from "../api/types";
import { Dialog } from "../ui/dialog";
import { say, sayFailure } from "../ui/toasts";
import { clampPriority, doTo, doToAll, jobsText, kActionWords, statesFor, type BulkAction, type BulkProgress } from "./bulk";
import type { Filter } from "./filter";
import { allJobs, countOf, statesBoth } from "./source";

export type Targets = { jobs: JobSummary[] } | { allOf: Filter };

interface Props {
  action: BulkAction;
  targets: Targets;
  onClose: () => void;
}

type Stage =
  | { name: "counting" }
  | { name: "asking"; count: number; of: number }
  | { name: "collecting"; found: number }
  | { name: "working"; progress: BulkProgress }
  | { name: "over"; progress: BulkProgress; stopped: boolean };

const kFailuresShown = 200;

export function BulkDialog({ action, targets, onClose }: Props) {
  const [stage, setStage] = useState<Stage>({ name: "counting" });
  const [priority, setPriority] = useState(action.kind === "priority" ? action.priority : 0);
  const stop = useRef(new AbortController());
  const words = kActionWords[action.kind];
  const states = statesFor(action);

  useEffect(() => {
    const counting = new AbortController();
    if ("jobs" in targets) {
      const count = targets.jobs.filter((job) => states.includes(job.state)).length;
      setStage({ name: "asking", count, of: targets.jobs.length });
    } else {
      const both = statesBoth(targets.allOf, states);
      const wanted = both.length === 0 ? Promise.resolve(0) : countOf({ ...targets.allOf, states: both }, counting.signal);
      Promise.all([wanted, countOf(targets.allOf, counting.signal)]).then(
        ([count, of]) => setStage({ name: "asking", count, of }),
        (failure: Error) => {
          sayFailure(failure);
          if (!counting.signal.aborted) onClose();
        },
      );
    }
    return () => {
      counting.abort();
      stop.current.abort();
    };
  }, []);

  // Enter goes on, but for what cannot be undone.
  const goOn = useRef<HTMLButtonElement>(null);
  useEffect(() => {
    if (stage.name === "asking" && action.kind !== "purge") goOn.current?.focus();
  }, [stage.name]);

  const go = async () => {
    const chosen: BulkAction = action.kind === "priority" ? { kind: "priority", priority } : action;
    try {
      let jobs: JobSummary[];
      if ("jobs" in targets) {
        jobs = targets.jobs.filter((job) => states.includes(job.state));
      } else {
        setStage({ name: "collecting", found: 0 });
        const tell = (found: number) => setStage({ name: "collecting", found });
        jobs = await allJobs(targets.allOf, statesBoth(targets.allOf, states), tell, stop.current.signal);
      }
      // The oldest first: what waits longest is done first, and the list is shortened from its end.
      const ids = jobs.map((job) => job.id).reverse();
      setStage({ name: "working", progress: { done: 0, total: ids.length, failures: [] } });
      let drawn = 0;
      const progress = await doToAll(
        ids,
        (id) => doTo(id, chosen),
        (now) => {
          if (performance.now() - drawn < 100) return;
          drawn = performance.now();
          setStage({ name: "working", progress: now });
        },
        stop.current.signal,
      );
      setStage({ name: "over", progress, stopped: stop.current.signal.aborted });
      if (progress.failures.length === 0 && !stop.current.signal.aborted) {
        say(`${jobsText(progress.done)} ${words.done}.`);
        onClose();
      }
    } catch (failure) {
      sayFailure(failure);
      onClose();
    }
  };

  const title = `${words.verb} ${"jobs" in targets ? jobsText(targets.jobs.length) : "all that match"}`;
  return (
    <Dialog title={title} onClose={onClose}>
      <div class="stack jobs-bulk">
        {stage.name === "counting" && <p class="muted">Counting …</p>}
        {stage.name === "asking" && (
          <>
            {stage.count === 0 ? (
              <p>None of {stage.of === 1 ? "it" : `the ${jobsText(stage.of)}`} is in a state for that: it goes for jobs that are {states.join(" or ")}.</p>
            ) : (
              <p>
                <strong>{jobsText(stage.count)}</strong> will be {words.done}
                {action.kind === "purge" && ", with their images and everything that was measured. That cannot be undone"}.
                {stage.count < stage.of && (
                  <>
                    {" "}
                    {jobsText(stage.of - stage.count)} {stage.of - stage.count === 1 ? "is" : "are"} left as{" "}
                    {stage.of - stage.count === 1 ? "it is" : "they are"}: not {states.join(" or ")}.
                  </>
                )}
                {action.kind === "cancel" && " What they rendered so far stays."}
              </p>
            )}
            {action.kind === "priority" && stage.count > 0 && (
              <label class="field">
                Priority, −100 to 100, higher first
                <input
                  type="number"
                  min={-100}
                  max={100}
                  value={priority}
                  onInput={(event) => setPriority(clampPriority(event.currentTarget.valueAsNumber || 0))}
                />
              </label>
            )}
            <div class="row">
              {stage.count > 0 && (
                <button ref={goOn} class={action.kind === "purge" ? "danger" : "primary"} onClick={() => void go()}>
                  {words.verb} {jobsText(stage.count)}
                </button>
              )}
              <button onClick={onClose}>{stage.count > 0 ? "Leave them" : "Close"}</button>
            </div>
          </>
        )}
        {stage.name === "collecting" && <p role="status">{stage.found.toLocaleString("en")} found …</p>}
        {(stage.name === "working" || stage.name === "over") && (
          <>
            <progress value={stage.progress.done} max={Math.max(1, stage.progress.total)} aria-label={title} />
            <p role="status">
              {stage.progress.done.toLocaleString("en")} of {jobsText(stage.progress.total)} asked for
              {stage.progress.failures.length > 0 && `, ${stage.progress.failures.length} refused`}
              {stage.name === "over" && stage.stopped && "; stopped"}.
            </p>
            {stage.progress.failures.length > 0 && (
              <ul class="jobs-failures" tabIndex={0} aria-label="What failed">
                {stage.progress.failures.slice(0, kFailuresShown).map(({ id, text }) => (
                  <li key={id}>
                    <a href={`/jobs/${id}`}>{id}</a> {text}
                  </li>
                ))}
                {stage.progress.failures.length > kFailuresShown && <li>and {stage.progress.failures.length - kFailuresShown} more</li>}
              </ul>
            )}
            <div class="row">
              {stage.name === "working" ? (
                <button onClick={() => stop.current.abort()}>Stop</button>
              ) : (
                <button class="primary" onClick={onClose}>
                  Close
                </button>
              )}
            </div>
          </>
        )}
      </div>
    </Dialog>
  );
}
