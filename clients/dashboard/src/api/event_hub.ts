// One event stream for all tabs: it is open while one of them looks, and a tab that has looked away is told what it has
// missed, or that it has.

import { EventStream, type Connection, type StreamEvent, type StreamReader } from "./event_stream";

/** Events that are kept for tabs which come back. */
export const kKept = 2000;

interface Kept {
  id: number;
  event: StreamEvent;
}

export class EventHub implements StreamReader {
  private readonly stream: EventStream;
  private readonly readers = new Set<StreamReader>();
  private kept: Kept[] = [];
  /** Every event with a greater number that has come is kept; null: none has come. */
  private keptFrom: number | null = null;
  private connection: Connection = "connecting";
  private status: StreamEvent | null = null;

  constructor(headers: () => Record<string, string>) {
    this.stream = new EventStream(headers, this);
  }

  /** `after`: the last event that the reader has heard, "" where it begins. */
  add(reader: StreamReader, after: string): void {
    if (this.readers.has(reader)) return;
    this.readers.add(reader);
    reader.turn(this.connection);
    if (this.status) reader.hear(this.status, null);
    if (after !== "") {
      const last = Number(after);
      if (this.keptFrom === null && !this.stream.runs) this.keptFrom = last;
      if (this.keptFrom === null || last < this.keptFrom) reader.hear({ type: "gap" }, null);
      else for (const { id, event } of this.kept) if (id > last) reader.hear(event, String(id));
    }
    this.stream.start(after);
  }

  remove(reader: StreamReader): void {
    if (this.readers.delete(reader) && this.readers.size === 0) this.stream.stop();
  }

  hear(event: StreamEvent, id: string | null): void {
    if (event.type === "status") this.status = event;
    // What was kept may be of another store, with other numbers.
    if (event.type === "gap") [this.kept, this.keptFrom] = [[], null];
    if (id !== null) {
      this.keptFrom ??= Number(id) - 1;
      this.kept.push({ id: Number(id), event });
      if (this.kept.length > kKept) this.keptFrom = this.kept.shift()!.id;
    }
    for (const reader of [...this.readers]) reader.hear(event, id);
  }

  turn(connection: Connection): void {
    this.connection = connection;
    for (const reader of [...this.readers]) reader.turn(connection);
  }
}
