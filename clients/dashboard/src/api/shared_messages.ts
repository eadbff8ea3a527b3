// What a tab and the browser's one worker for all tabs (shared_worker.ts) say to each other.

import type { Connection, StreamEvent } from "./event_stream";
import type { SlowAnswer } from "./slow_requests";

export type ToWorker =
  /** First, and where the token is another. A tab without one is told that of the others. */
  | { kind: "hello"; token: string | null }
  /** Tell me of events, those after this one too. */
  | { kind: "listen"; after: string }
  /** Nobody looks at this tab: no events. */
  | { kind: "rest" }
  /** `number` is the tab's own. */
  | { kind: "ask"; number: number; path: string }
  | { kind: "drop"; number: number }
  /** In all tabs. */
  | { kind: "sign out" }
  /** The tab is closed. */
  | { kind: "bye" };

export type ToTab =
  | { kind: "token"; token: string }
  | { kind: "signed out" }
  | { kind: "event"; event: StreamEvent; id: string | null }
  | { kind: "connection"; connection: Connection }
  | { kind: "answer"; number: number; answer: SlowAnswer }
  /** Nobody answered. */
  | { kind: "failed"; number: number };
