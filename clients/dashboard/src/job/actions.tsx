// What can be done to a job: each only where the daemon would do it.

import { useLocation } from "preact-iso";
import { useState } from "preact/hooks";

import { Problem, sendJson } from "../api/client";
import { isOver, type Fault, type Job, type StopConditions } from "../api/types";
import { clampPriority, doTo, type BulkAction } from "../jobs/bulk";
import { ActionButton } from "../ui/action_button";
import { Dialog } from "../ui/dialog";
import { stopText } from "../ui/format";
import { StopFields } from "../ui/stop_fields";
import { say, sayFailure } from "../ui/toasts";

interface Props {
  job: Job;
  onChanged: () => void;
}

function ExtendDialog({ job, onChanged, onClose }: Props & { onClose: () => void }) {
  const { passes, seconds, target } = job.request.stop;
  const [stop, setStop] = useState<StopConditions>({
    ...(passes ? { passes: 4 * Math.max(passes, job.passes_done) } : {}),
    ...(seconds && !passes ? { seconds: 4 * Math.max(seconds, job.seconds) } : {}),
    ...(target && !passes && !seconds ? { target: { metric: target.metric, value: target.value / 4 } } : {}),
  });
  const [faults, setFaults] = useState<Fault[]>([]);
  const [refusal, setRefusal] = useState("");
  const extend = async () => {
    try {
      await sendJson("POST", `/v1/jobs/${job.id}/extend`, { stop });
      say(`${job.id} goes on: ${stopText(stop)}.`);
      onChanged();
      onClose();
    } catch (failure) {
      if (!(failure instanceof Problem)) return sayFailure(failure);
      setFaults(failure.faults);
      setRefusal(failure.faults.length === 0 ? failure.message : "");
    }
  };
  return (
    <Dialog title={`Extend ${job.id}`} onClose={onClose}>
      <form
        class="stack job-dialog"
        onSubmit={(event) => {
          event.preventDefault();
          void extend();
        }}
      >
        <p class="hint">
          More passes on the same film, counted from its first: it has {job.passes_done.toLocaleString("en")} after {stopText({ seconds: job.seconds })}.
          What comes of it is what one longer job would have given.
        </p>
        <StopFields value={stop} onChange={setStop} metrics={Object.keys(job.curve?.at(-1)?.metrics ?? {})} faults={faults} idPrefix="extend" />
        {refusal && <p class="notice failed">{refusal}</p>}
        <div class="row">
          <button class="primary">Extend</button>
          <button type="button" onClick={onClose}>
            Leave it
          </button>
        </div>
      </form>
    </Dialog>
  );
}

function PriorityDialog({ job, onChanged, onClose }: Props & { onClose: () => void }) {
  const [priority, setPriority] = useState(job.request.priority);
  return (
    <Dialog title={`Priority of ${job.id}`} onClose={onClose}>
      <form
        class="stack job-dialog"
        onSubmit={(event) => {
          event.preventDefault();
          onClose();
          say(`${job.id}: priority ${priority} …`);
          doTo(job.id, { kind: "priority", priority }).then(onChanged, sayFailure);
        }}
      >
        <label class="field">
          Priority, −100 to 100, higher first
          <input type="number" min={-100} max={100} value={priority} onInput={(event) => setPriority(clampPriority(event.currentTarget.valueAsNumber || 0))} />
        </label>
        {job.state === "running" && <p class="hint">It runs already: the priority is for its next attempt.</p>}
        <div class="row">
          <button class="primary">Set</button>
        </div>
      </form>
    </Dialog>
  );
}

function PurgeDialog({ job, onClose }: { job: Job; onClose: () => void }) {
  const { route } = useLocation();
  const purge = () =>
    doTo(job.id, { kind: "purge" }).then(() => {
      say(`${job.id} removed.`);
      route("/jobs");
    });
  return (
    <Dialog title={`Remove ${job.id}`} onClose={onClose}>
      <div class="stack job-dialog">
        <p>
          The job goes, with its image and everything that was measured{isOver(job.state) ? "" : "; it is cancelled first"}. That cannot be undone.
        </p>
        <div class="row">
          <ActionButton class="danger" busy="Removing …" until={job.id} run={purge}>
            Remove
          </ActionButton>
          <button onClick={onClose}>Leave it</button>
        </div>
      </div>
    </Dialog>
  );
}

export type Asked = "extend" | "priority" | "purge" | null;

/** Does what needs no question, and says so. */
export async function doNow(job: Job, action: BulkAction, done: string, onChanged: () => void): Promise<void> {
  await doTo(job.id, action);
  say(`${job.id} ${done}.`);
  onChanged();
}

export function Actions({ job, onChanged, asked, ask }: Props & { asked: Asked; ask: (what: Asked) => void }) {
  const over = isOver(job.state);
  const canRetry = job.state === "failed" || job.state === "cancelled";
  const canExtend = over && job.passes_done > 0 && job.role !== "merged";
  return (
    <>
      <a class="button" href={`/render?from=${job.id}`}>
        Clone and edit
      </a>
      {canExtend && <button onClick={() => ask("extend")}>Extend</button>}
      {canRetry && (
        <ActionButton class="primary" busy="Queueing it …" until={job.state} run={() => doNow(job, { kind: "retry" }, "is queued again", onChanged)}>
          Retry
        </ActionButton>
      )}
      {!over && (
        <>
          <button onClick={() => ask("priority")}>Priority {job.request.priority}</button>
          <ActionButton class="danger" busy="Cancelling …" until={job.state} run={() => doNow(job, { kind: "cancel" }, "cancelled; what it rendered stays", onChanged)}>
            Cancel
          </ActionButton>
        </>
      )}
      <button class="quiet" onClick={() => ask("purge")}>
        Remove
      </button>
      {asked === "extend" && <ExtendDialog job={job} onChanged={onChanged} onClose={() => ask(null)} />}
      {asked === "priority" && <PriorityDialog job={job} onChanged={onChanged} onClose={() => ask(null)} />}
      {asked === "purge" && <PurgeDialog job={job} onClose={() => ask(null)} />}
    </>
  );
}
