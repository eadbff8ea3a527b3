// What the daemon's one event stream tells, for whoever on this page wants to hear of jobs.

import { signal } from "@preact/signals";

import type { Connection, StreamEvent } from "./event_stream";
import { startShared } from "./shared";
import { needsToken } from "./token";
import type { DaemonStatus } from "./types";

export type { StreamEvent };
type Listener = (event: StreamEvent) => void;

const kPatienceMs = 1000;

/** "live" while events come, "lost" while the daemon does not answer. */
export const connection = signal<Exclude<Connection, "refused">>("connecting");
/** The last the stream said of the daemon itself. */
export const daemonStatus = signal<DaemonStatus | null>(null);

const listeners = new Set<Listener>();

/** Calls back with every event from now on; returns how to stop. */
export function listen(listener: Listener): () => void {
  listeners.add(listener);
  return () => listeners.delete(listener);
}

function tell(event: StreamEvent): void {
  if (event.type === "status") daemonStatus.value = event.status;
  for (const listener of [...listeners]) listener(event);
}

/**
 * Opens the stream, and keeps it open while the page is looked at. Ends once it is open, so that a room which asks for a
 * list afterwards hears of whatever changes in it; or after a second, and then tells of a gap when it is.
 */
export function startEvents(): Promise<void> {
  return new Promise((begin) => {
    let waits = true;
    const end = () => {
      waits = false;
      begin();
    };
    setTimeout(end, kPatienceMs);
    startShared({
      hear: tell,
      turn: (now) => {
        if (now === "refused") {
          needsToken.value = true;
          return end();
        }
        const isFirst = connection.peek() === "connecting" && now === "live";
        connection.value = now;
        if (isFirst && !waits) tell({ type: "gap" });
        if (now !== "connecting") end();
      },
    });
  });
}
