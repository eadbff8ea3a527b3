import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";

import { EventHub, kKept } from "./event_hub";
import type { Connection, StreamEvent } from "./event_stream";

class Reader {
  events: string[] = [];
  turns: Connection[] = [];
  hear = (event: StreamEvent, id: string | null) => this.events.push(event.type === "state" ? `${id} ${event.change.id}` : event.type);
  turn = (connection: Connection) => this.turns.push(connection);
}

const state = (id: number) => `event: state\nid: ${id}\ndata: {"id":"J${id}"}\n\n`;
const settle = () => vi.advanceTimersByTimeAsync(1);

describe("EventHub", () => {
  /** Every connection to the daemon: what it asked with, and how to send on it and end it. */
  const opened: { after: string | undefined; signal: AbortSignal; send: (text: string) => Promise<unknown>; end: () => Promise<unknown> }[] = [];
  let status = 200;
  beforeEach(() => {
    vi.useFakeTimers();
    opened.length = 0;
    status = 200;
    vi.stubGlobal("fetch", (_path: string, { headers, signal }: { headers: Record<string, string>; signal: AbortSignal }) => {
      const bytes = new TransformStream<Uint8Array, Uint8Array>();
      const writer = bytes.writable.getWriter();
      opened.push({
        after: headers["Last-Event-ID"],
        signal,
        send: (text) => (void writer.write(new TextEncoder().encode(text)), settle()),
        end: () => (void writer.close(), settle()),
      });
      return Promise.resolve(new Response(status === 200 ? bytes.readable : null, { status }));
    });
  });
  afterEach(() => {
    vi.useRealTimers();
    vi.unstubAllGlobals();
  });
  const hub = () => new EventHub(() => ({}));

  it("opens one stream for all readers, and closes it with the last", async () => {
    const all = hub();
    const readers = Array.from({ length: 10 }, () => new Reader());
    for (const reader of readers) all.add(reader, "");
    await settle();
    await opened[0]!.send(state(7));
    expect(opened).toHaveLength(1);
    for (const reader of readers) expect(reader.events).toEqual(["7 J7"]);
    for (const reader of readers.slice(1)) all.remove(reader);
    expect(opened[0]!.signal.aborted).toBe(false);
    await opened[0]!.send(state(8));
    expect(readers[0]!.events).toEqual(["7 J7", "8 J8"]);
    expect(readers[1]!.events).toEqual(["7 J7"]);
    all.remove(readers[0]!);
    expect(opened[0]!.signal.aborted).toBe(true);
  });

  it("tells one that comes back what it has missed, each event once", async () => {
    const all = hub();
    const [stays, leaves] = [new Reader(), new Reader()];
    all.add(stays, "");
    all.add(leaves, "");
    await settle();
    await opened[0]!.send(state(1));
    all.remove(leaves);
    await opened[0]!.send(state(2) + state(3));
    all.add(leaves, "1");
    await opened[0]!.send(state(4));
    expect(leaves.events).toEqual(["1 J1", "2 J2", "3 J3", "4 J4"]);
    expect(opened).toHaveLength(1);
  });

  it("goes on from its last event when all had left", async () => {
    const all = hub();
    const reader = new Reader();
    all.add(reader, "");
    await settle();
    await opened[0]!.send(state(5));
    all.remove(reader);
    all.add(reader, "5");
    await settle();
    expect(opened.map(({ after }) => after)).toEqual([undefined, "5"]);
    await opened[1]!.send(state(6));
    expect(reader.events).toEqual(["5 J5", "6 J6"]);
  });

  it("goes on from the last event of its first reader, as a new worker does", async () => {
    const all = hub();
    const reader = new Reader();
    all.add(reader, "41");
    await settle();
    expect(opened[0]!.after).toBe("41");
    expect(reader.events).toEqual([]);
    const other = new Reader();
    all.add(other, "12"); // of whose events it knows nothing
    expect(other.events).toEqual(["gap"]);
  });

  it("says so where what was missed is not kept any more", async () => {
    const all = hub();
    const [stays, leaves] = [new Reader(), new Reader()];
    all.add(stays, "");
    await settle();
    await opened[0]!.send(Array.from({ length: kKept + 2 }, (_, i) => state(i + 1)).join(""));
    all.add(leaves, "1");
    expect(leaves.events).toEqual(["gap"]);
    const other = new Reader();
    all.add(other, "2");
    expect(other.events).toHaveLength(kKept);
  });

  it("asks again after a lost connection, and tells of a gap", async () => {
    const all = hub();
    const reader = new Reader();
    all.add(reader, "");
    await settle();
    await opened[0]!.send(state(1));
    status = 502;
    await opened[0]!.end();
    await vi.advanceTimersByTimeAsync(1500);
    status = 200;
    await vi.advanceTimersByTimeAsync(1500);
    expect(reader.turns).toEqual(["connecting", "live", "lost", "live"]);
    expect(reader.events).toEqual(["1 J1", "gap"]);
    expect(opened.at(-1)!.after).toBe("1");
  });

  it("asks no more once its token is refused", async () => {
    status = 401;
    const all = hub();
    const reader = new Reader();
    all.add(reader, "");
    await vi.advanceTimersByTimeAsync(5000);
    expect(reader.turns).toEqual(["connecting", "refused"]);
    expect(opened).toHaveLength(1);
  });
});
