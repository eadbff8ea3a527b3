// A tab's side of the worker that all tabs share (shared_worker.ts); where a browser has no such worker, the tab does the
// same for itself. A tab that nobody looks at hears of no events, and goes on from the last one when it is looked at again.

import { EventStream, type StreamReader } from "./event_stream";
import type { ToTab, ToWorker } from "./shared_messages";
import { type SlowAnswer, SlowRequests } from "./slow_requests";
import { forgetToken, needsToken, takeToken, token } from "./token";
import { authorization } from "./token_header";

/** A daemon that is there says something each second. Silence for so long: the worker may be gone. */
const kSilenceMs = 15_000;

interface Asked {
  path: string;
  stop: AbortSignal;
  answer: (answer: SlowAnswer) => void;
  fail: (failure: Error) => void;
}

/** Whatever is for all tabs. */
interface Shared {
  ask(path: string, stop: AbortSignal): Promise<SlowAnswer>;
  listen(): void;
  rest(): void;
  signOut(): void;
}

class Alone implements Shared {
  private readonly slow = new SlowRequests();
  private readonly stream: EventStream;

  constructor(reader: StreamReader) {
    this.stream = new EventStream(() => authorization(token()), reader);
  }

  ask = (path: string, stop: AbortSignal) => this.slow.ask({ path, token: token() }, stop);
  listen = () => this.stream.start();
  rest = () => this.stream.stop();
  signOut = signedOut;
}

class ByWorker implements Shared {
  private port: MessagePort | null = null;
  private readonly asked = new Map<number, Asked>();
  private lastId = "";
  private number = 0;
  private heardAt = 0;
  private listens = false;

  private readonly watch: number;

  /** `failed`: there is no worker after all; who does what was asked of it is returned. */
  constructor(
    private readonly reader: StreamReader,
    private readonly failed: () => Shared,
  ) {
    this.connect();
    window.addEventListener("pagehide", () => this.say({ kind: "bye" }));
    window.addEventListener("pageshow", (event) => event.persisted && this.connect());
    this.watch = window.setInterval(() => {
      if (this.listens && performance.now() - this.heardAt > kSilenceMs) this.connect();
    }, kSilenceMs / 3);
  }

  ask(path: string, stop: AbortSignal): Promise<SlowAnswer> {
    return new Promise((answer, fail) => {
      if (stop.aborted) return fail(stop.reason as Error);
      const number = ++this.number;
      this.asked.set(number, { path, stop, answer, fail });
      stop.addEventListener("abort", () => {
        if (!this.asked.delete(number)) return;
        this.say({ kind: "drop", number });
        fail(stop.reason as Error);
      });
      this.say({ kind: "ask", number, path });
    });
  }

  listen(): void {
    if (this.listens) return;
    this.listens = true;
    this.heardAt = performance.now();
    this.say({ kind: "listen", after: this.lastId });
  }

  rest(): void {
    this.listens = false;
    this.say({ kind: "rest" });
  }

  signOut(): void {
    this.say({ kind: "sign out" });
  }

  private say(message: ToWorker): void {
    this.port?.postMessage(message);
  }

  /** To a worker that is there, or a new one; what was asked of an earlier one is asked again. */
  private connect(): void {
    this.say({ kind: "bye" });
    const worker = new SharedWorker(new URL("./shared_worker.ts", import.meta.url), { type: "module", name: "photond" });
    worker.onerror = () => this.giveUp();
    this.port = worker.port;
    this.port.onmessage = ({ data }) => this.take(data as ToTab);
    this.heardAt = performance.now();
    this.say({ kind: "hello", token: token() });
    if (this.listens) this.say({ kind: "listen", after: this.lastId });
    for (const [number, { path }] of this.asked) this.say({ kind: "ask", number, path });
  }

  private giveUp(): void {
    clearInterval(this.watch);
    const other = this.failed();
    for (const { path, stop, answer, fail } of this.asked.values()) other.ask(path, stop).then(answer, fail);
    this.asked.clear();
  }

  private take(message: ToTab): void {
    this.heardAt = performance.now();
    switch (message.kind) {
      case "token":
        if (token()) break;
        takeToken(message.token, false);
        window.location.reload();
        break;
      case "signed out":
        signedOut();
        break;
      case "event":
        if (message.id !== null) this.lastId = message.id;
        this.reader.hear(message.event, message.id);
        break;
      case "connection":
        this.reader.turn(message.connection);
        break;
      case "answer":
        this.asked.get(message.number)?.answer(message.answer);
        this.asked.delete(message.number);
        break;
      case "failed":
        this.asked.get(message.number)?.fail(new TypeError("the daemon does not answer"));
        this.asked.delete(message.number);
        break;
    }
  }
}

let shared: Shared | null = null;

/** Nothing that was shown stays in the page. */
function signedOut(): void {
  forgetToken();
  window.location.assign("/");
}

/** To be called once, before anything is asked for. Follows the stream while the page is looked at. */
export function startShared(reader: StreamReader): void {
  const look = () => (document.hidden ? shared!.rest() : shared!.listen());
  const alone = () => {
    shared = new Alone(reader);
    look();
    return shared;
  };
  document.addEventListener("visibilitychange", look);
  if (!("SharedWorker" in window)) return void alone();
  shared = new ByWorker(reader, alone);
  look();
}

/** The answer to a GET that may take the daemon some time. Rejects with an AbortError, or where nobody answers. */
export function askSlowly(path: string, stop: AbortSignal): Promise<SlowAnswer> {
  return shared!.ask(path, stop);
}

/** In all tabs of this browser. */
export function signOut(): void {
  needsToken.value = true;
  forgetToken();
  shared!.signOut();
}
