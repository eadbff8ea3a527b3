// One connection that reads /v1/events, begun anew wherever it ends and going on from the last event. It is read by
// fetch(), for an EventSource cannot carry a token.

import { createParser } from "eventsource-parser";

import type { DaemonStatus, JobChange } from "./types";

export type StreamEvent =
  | { type: "state" | "progress" | "curve"; change: JobChange }
  | { type: "status"; status: DaemonStatus }
  /** Events may have been missed: whoever keeps what they told asks anew. */
  | { type: "gap" };

/** "live" while events come, "lost" while the daemon does not answer, "refused" where it wants another token. */
export type Connection = "connecting" | "live" | "lost" | "refused";

export interface StreamReader {
  /** `id` of an event that one can go on from; null of others. */
  hear(event: StreamEvent, id: string | null): void;
  turn(connection: Connection): void;
}

const kRetryMs = 1000;

function readEvent(type: string | undefined, text: string): StreamEvent | null {
  switch (type) {
    case "status":
      return { type, status: JSON.parse(text) as DaemonStatus };
    case "state":
    case "progress":
    case "curve":
      return { type, change: JSON.parse(text) as JobChange };
    default:
      return null;
  }
}

export class EventStream {
  private current: AbortController | null = null;
  /** Whether something may have been told while nobody listened, and nothing says where to go on from. */
  private missed = false;

  constructor(
    private readonly headers: () => Record<string, string>,
    private readonly reader: StreamReader,
    private lastId = "",
  ) {}

  /**
   * Follows the stream until stop(), or until the token is refused; again from the last event after that. `after`: an event
   * heard elsewhere.
   */
  start(after = ""): void {
    if (this.current) return;
    this.lastId ||= after;
    void this.follow((this.current = new AbortController()));
  }

  get runs(): boolean {
    return this.current !== null;
  }

  stop(): void {
    this.current?.abort();
    this.current = null;
  }

  private async follow(stop: AbortController): Promise<void> {
    while (!stop.signal.aborted) {
      try {
        await this.read(stop.signal);
      } catch {
        if (stop.signal.aborted) return;
        this.reader.turn("lost");
        // It may come back with another store, which knows nothing of our number and starts with what happens then.
        this.missed = true;
      }
      await new Promise((done) => setTimeout(done, kRetryMs));
    }
  }

  private async read(stop: AbortSignal): Promise<void> {
    const answer = await fetch("/v1/events", {
      signal: stop,
      headers: { ...this.headers(), ...(this.lastId ? { "Last-Event-ID": this.lastId } : {}) },
      cache: "no-store",
    });
    if (answer.status === 401) {
      this.stop();
      return this.reader.turn("refused");
    }
    if (!answer.ok) throw new Error(answer.statusText);
    this.reader.turn("live");
    if (this.missed) this.reader.hear({ type: "gap" }, null);
    this.missed = !this.lastId; // a stream that ends before its first event with a number
    const parser = createParser({
      onEvent: (message) => {
        const event = readEvent(message.event, message.data);
        if (message.id !== undefined) {
          this.lastId = message.id;
          this.missed = false;
        }
        if (event) this.reader.hear(event, message.id ?? null);
      },
    });
    const text = answer.body!.pipeThrough(new TextDecoderStream()).getReader();
    for (;;) {
      const { done, value } = await text.read();
      if (done || stop.aborted) return;
      parser.feed(value);
    }
  }
}
