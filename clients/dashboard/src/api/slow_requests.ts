// What the daemon may take its time for, pictures above all: few at once, since a browser has but six connections a host
// for all its tabs and buttons come first. None is held for what is not there yet: the daemon says when to ask again.

import { authorization } from "./token_header";

/** An answer as it passes from one thread to another. */
export interface SlowAnswer {
  status: number;
  statusText: string;
  headers: [string, string][];
  body: Blob;
}

export interface SlowRequest {
  path: string;
  token: string | null;
}

export const kAtOnce = 2;

interface Waiting {
  request: SlowRequest;
  stop: AbortSignal;
  answer: (answer: SlowAnswer) => void;
  fail: (failure: unknown) => void;
}

async function fetchSlowly({ path, token }: SlowRequest, signal: AbortSignal): Promise<SlowAnswer> {
  const answer = await fetch(path, { signal, priority: "low", headers: { ...authorization(token), Prefer: "respond-async" } });
  // The whole of it: a body that nobody reads would keep its connection.
  return { status: answer.status, statusText: answer.statusText, headers: [...answer.headers], body: await answer.blob() };
}

export class SlowRequests {
  private readonly waiting: Waiting[] = [];
  private running = 0;

  constructor(private readonly send: (request: SlowRequest, signal: AbortSignal) => Promise<SlowAnswer> = fetchSlowly) {}

  /** First come, first served; one that is stopped leaves the line, or its connection. */
  ask(request: SlowRequest, stop: AbortSignal): Promise<SlowAnswer> {
    return new Promise((answer, fail) => {
      if (stop.aborted) return fail(stop.reason);
      const place: Waiting = { request, stop, answer, fail };
      stop.addEventListener("abort", () => this.leave(place), { once: true });
      this.waiting.push(place);
      this.next();
    });
  }

  private leave(place: Waiting): void {
    const at = this.waiting.indexOf(place);
    if (at < 0) return; // under way: its fetch() ends by the same signal
    this.waiting.splice(at, 1);
    place.fail(place.stop.reason);
  }

  private next(): void {
    while (this.running < kAtOnce) {
      const place = this.waiting.shift();
      if (!place) return;
      ++this.running;
      this.send(place.request, place.stop)
        .then(place.answer, place.fail)
        .finally(() => {
          --this.running;
          this.next();
        });
    }
  }
}
