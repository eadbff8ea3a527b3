// Who is next, and why one that stands before others does not begin.

import { sendJson } from "../api/client";
import type { JobSummary } from "../api/types";
import { plainName, sizeText } from "../ui/format";
import { sceneName } from "../ui/scene_names";
import { sayFailure } from "../ui/toasts";

const kStep = 10;
const clampPriority = (priority: number) => Math.max(-100, Math.min(100, priority));

function Row({ row }: { row: JobSummary }) {
  const change = (priority: number) =>
    sendJson("PATCH", `/v1/jobs/${row.id}`, { priority: clampPriority(priority) }).catch((failure: unknown) => sayFailure(failure));
  return (
    <li class="now-queue-row">
      <span class="now-queue-what">
        <a href={`/jobs/${row.id}`}>{row.id}</a> {plainName(row.method)}
        <span class="muted small">
          {sceneName(row.scene)} · {sizeText(row)} · {row.device}
          {row.role === "reference" ? " · reference" : ""}
          {row.comparison ? ` · study ${row.comparison}` : ""}
        </span>
        {row.waiting_for && !row.waits_for && !row.waiting_for.startsWith("its turn") && <span class="small now-waits">waits for {row.waiting_for}</span>}
        {row.waits_for && (
          <span class="small now-waits">
            waits for its reference, <a href={`/jobs/${row.waits_for}`}>{row.waits_for}</a>
          </span>
        )}
      </span>
      <span class="now-priority" role="group" aria-label={`Priority of ${row.id}`}>
        <button class="quiet" aria-label={`${row.id} later`} disabled={row.priority <= -100} onClick={() => void change(row.priority - kStep)}>
          −
        </button>
        <span title="Priority: higher first">{row.priority}</span>
        <button class="quiet" aria-label={`${row.id} sooner`} disabled={row.priority >= 100} onClick={() => void change(row.priority + kStep)}>
          +
        </button>
      </span>
    </li>
  );
}

export function Queue({ queue, queued }: { queue: JobSummary[]; queued: number }) {
  return (
    <section class="panel" aria-labelledby="now-queue">
      <h2 id="now-queue">
        Next <span class="muted">{queued > 0 ? `${queued.toLocaleString("en")} waiting` : ""}</span>
      </h2>
      {queue.length === 0 ? (
        <p class="muted">Nothing waits.</p>
      ) : (
        <>
          <div class="now-queue-head muted small" aria-hidden="true">
            <span>job</span>
            <span>priority</span>
          </div>
          <ol class="now-queue">
            {queue.map((row) => (
              <Row key={row.id} row={row} />
            ))}
          </ol>
          {queued > queue.length && (
            <p class="small">
              <a href="/jobs?state=queued">All {queued.toLocaleString("en")} that wait</a>
            </p>
          )}
        </>
      )}
    </section>
  );
}
