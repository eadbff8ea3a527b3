// State over time: waiting, attempts, losses, as a line and as a table.

import { useEffect, useState } from "preact/hooks";

import { isOver, type Job } from "../api/types";
import { kNone, plainName, secondsText, timeText } from "../ui/format";
import { spansOf, type Span } from "./merge";

const kTickMs = 1000;

/** A short mark for each outcome beside its colour, so that neither is needed to read the other. */
const kLooks: Record<string, string> = { succeeded: "succeeded", running: "running", cancelled: "waiting", stopped: "waiting" };
const lookOf = (span: Span): string => (span.kind === "waiting" ? "waiting" : (kLooks[span.outcome] ?? "failed"));

export function Life({ job }: { job: Job }) {
  const [now, setNow] = useState(Date.now());
  useEffect(() => {
    if (isOver(job.state)) return;
    setNow(Date.now());
    const timer = setInterval(() => setNow(Date.now()), kTickMs);
    return () => clearInterval(timer);
  }, [job.state]);
  const spans = spansOf(job, now);
  const whole = Math.max(1, spans.reduce((sum, span) => sum + span.end - span.start, 0));
  return (
    <>
      <div class="job-life" aria-hidden="true">
        {spans.map((span) => (
          <span
            key={`${span.start} ${span.title}`}
            class={`job-span ${lookOf(span)}`}
            style={{ flexGrow: Math.max(0.004, (span.end - span.start) / whole) }}
            title={`${span.title}${span.outcome ? `: ${plainName(span.outcome)}` : ""}, ${secondsText((span.end - span.start) / 1000)}`}
          />
        ))}
      </div>
      <div class="scroll-x">
        <table class="job-table">
          <thead>
            <tr>
              <th>What</th>
              <th>From</th>
              <th class="number">Lasted</th>
              <th>Device</th>
              <th class="number">Passes</th>
              <th>Outcome</th>
            </tr>
          </thead>
          <tbody>
            {spans.map((span) => (
              <tr key={`${span.start} ${span.title}`}>
                <td>{span.title}</td>
                <td>{timeText(new Date(span.start).toISOString())}</td>
                <td class="number">{secondsText((span.end - span.start) / 1000)}</td>
                <td>{span.device ?? kNone}</td>
                <td class="number">{span.passes ?? kNone}</td>
                <td>
                  {span.outcome ? plainName(span.outcome) : kNone}
                  {span.reason && <span class="muted">: {span.reason}</span>}
                </td>
              </tr>
            ))}
          </tbody>
        </table>
      </div>
    </>
  );
}
