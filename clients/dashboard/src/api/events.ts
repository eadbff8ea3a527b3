// The daemon's one event stream, /v1/events, for whoever on this page wants to hear of jobs. It is read by fetch(), for
// an EventSource cannot carry a token. A page that nobody looks at lets go of its connection, of which a browser has
// but six a host, and goes on from the last event when it is looked at again.

import { signal } from "@preact/signals";
import { createParser, type EventSourceMessage } from "eventsource-parser";

import { ask, needsToken } from "./client";
import type { DaemonStatus, JobChange } from "./types";

export type StreamEvent =
  | { type: "state" | "progress" | "curve"; change: JobChange }
  | { type: "status"; status: DaemonStatus }
  /** Events may have been missed: whoever keeps what they told asks anew. */
  | { type: "gap" };
type Listener = (event: StreamEvent) => void;

const kRetryMs = 1000;

/** "live" while events come, "lost" while the daemon does not answer. */
export const connection = signal<"connecting" | "live" | "lost">("connecting");
/** The last the stream said of the daemon itself. */
export const daemonStatus = signal<DaemonStatus | null>(null);

const listeners = new Set<Listener>();
let lastId = "";
let current: AbortController | null = null;
/** Whether something may have been told while nobody listened, and nothing says where to go on from. */
let missed = false;

/** Calls back with every event from now on; returns how to stop. */
export function listen(listener: Listener): () => void {
  listeners.add(listener);
  return () => listeners.delete(listener);
}

function tell(event: StreamEvent): void {
  for (const listener of [...listeners]) listener(event);
}

function take(message: EventSourceMessage): void {
  if (message.id !== undefined) {
    lastId = message.id;
    missed = false;
  }
  const data: unknown = JSON.parse(message.data);
  switch (message.event) {
    case "status":
      daemonStatus.value = data as DaemonStatus;
      tell({ type: "status", status: data as DaemonStatus });
      break;
    case "state":
    case "progress":
    case "curve":
      tell({ type: message.event, change: data as JobChange });
      break;
  }
}

async function readStream(stop: AbortController): Promise<void> {
  const answer = await ask("/v1/events", {
    signal: stop.signal,
    headers: lastId ? { "Last-Event-ID": lastId } : {},
    cache: "no-store",
  });
  connection.value = "live";
  if (missed) tell({ type: "gap" });
  missed = !lastId; // a stream that ends before its first event with a number
  const parser = createParser({ onEvent: take });
  const text = answer.body!.pipeThrough(new TextDecoderStream()).getReader();
  for (;;) {
    const { done, value } = await text.read();
    if (done) return;
    parser.feed(value);
  }
}

async function follow(): Promise<void> {
  if (current) return;
  const stop = (current = new AbortController());
  while (!stop.signal.aborted) {
    try {
      if (!needsToken.value) await readStream(stop);
    } catch {
      if (stop.signal.aborted) break;
      connection.value = "lost";
      // It may come back with another store, which knows nothing of our number and starts with what happens then.
      missed = true;
    }
    await new Promise((done) => setTimeout(done, kRetryMs));
  }
}

/** Opens the stream, and keeps it open while the page is looked at. */
export function startEvents(): void {
  document.addEventListener("visibilitychange", () => {
    if (document.hidden) {
      current?.abort();
      current = null;
    } else {
      void follow();
    }
  });
  if (!document.hidden) void follow();
}
