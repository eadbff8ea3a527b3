// The browser's one worker for all tabs of the dashboard (a SharedWorker): it reads one event stream for all of them,
// and asks for their pictures, a few at once. It ends with the last tab, so that no tab leads and none has to take over.

import { EventHub } from "./event_hub";
import type { StreamReader } from "./event_stream";
import type { ToTab, ToWorker } from "./shared_messages";
import { SlowRequests } from "./slow_requests";
import { authorization } from "./token_header";

const slow = new SlowRequests();
const hubs = new Map<string | null, EventHub>();
const tabs = new Set<Tab>();
/** That of the tab which has signed in last, for tabs that have none yet. Never on disk. */
let known: string | null = null;

/** Tabs may have signed in as different people. */
function hubOf(token: string | null): EventHub {
  let hub = hubs.get(token);
  if (!hub) hubs.set(token, (hub = new EventHub(() => authorization(token))));
  return hub;
}

class Tab implements StreamReader {
  private token: string | null = null;
  private readonly asked = new Map<number, AbortController>();

  constructor(private readonly port: MessagePort) {
    port.onmessage = ({ data }) => this.take(data as ToWorker);
  }

  /** Of another tab's token, where this one has none. */
  learn(token: string): void {
    if (!this.token) this.say({ kind: "token", token });
  }

  say(message: ToTab): void {
    this.port.postMessage(message);
  }

  hear: StreamReader["hear"] = (event, id) => this.say({ kind: "event", event, id });
  turn: StreamReader["turn"] = (connection) => this.say({ kind: "connection", connection });

  private take(message: ToWorker): void {
    switch (message.kind) {
      case "hello":
        tabs.add(this);
        hubOf(this.token).remove(this);
        this.token = message.token ?? known;
        if (message.token) {
          known = message.token;
          for (const tab of tabs) tab.learn(known);
        } else if (known) {
          this.say({ kind: "token", token: known });
        }
        break;
      case "listen":
        hubOf(this.token).add(this, message.after);
        break;
      case "rest":
        hubOf(this.token).remove(this);
        break;
      case "ask":
        void this.ask(message.number, message.path);
        break;
      case "drop":
        this.asked.get(message.number)?.abort();
        break;
      case "sign out":
        known = null;
        for (const tab of tabs) tab.say({ kind: "signed out" });
        break;
      case "bye":
        tabs.delete(this);
        hubOf(this.token).remove(this);
        for (const stop of this.asked.values()) stop.abort();
        break;
    }
  }

  private async ask(number: number, path: string): Promise<void> {
    const stop = new AbortController();
    this.asked.set(number, stop);
    try {
      const answer = await slow.ask({ path, token: this.token }, stop.signal);
      this.say({ kind: "answer", number, answer });
    } catch {
      if (!stop.signal.aborted) this.say({ kind: "failed", number });
    }
    this.asked.delete(number);
  }
}

(globalThis as unknown as { onconnect: (event: MessageEvent) => void }).onconnect = (event) => new Tab(event.ports[0]!);
