// Pixels that are held: fetched a few at a time in the order in which they are wanted, kept while others are looked at.

import { signal } from "@preact/signals";

import type { Fetched, PixelImage } from "./pixels";

export interface Entry {
  /** The newest there is, kept while a newer one is fetched. */
  image: PixelImage | null;
  flipMean: number | null;
  loading: boolean;
  /** Nothing is rendered yet. */
  waiting: boolean;
  failure: Error | null;
  /** Which version `image`, or the failure, is of. */
  version: number;
}

export interface Wanted {
  key: string;
  version: number;
  fetch: (signal: AbortSignal) => Promise<Fetched | null>;
}

const kAtOnce = 3;
const kUnwantedBytes = 512 * 2 ** 20;
const kEmpty: Entry = { image: null, flipMean: null, loading: true, waiting: false, failure: null, version: -1 };

export class PixelStore {
  readonly entries = signal<ReadonlyMap<string, Entry>>(new Map());
  private wanted: Wanted[] = [];
  private running = new Map<string, { version: number; stop: AbortController }>();
  /** Keys in the order in which they were last wanted. */
  private recent: string[] = [];

  /** Fetches what is missing or old of these, the first ones first, and no longer what is not among them. */
  want(wanted: Wanted[]): void {
    this.wanted = wanted;
    const keys = new Set(wanted.map((one) => one.key));
    for (const [key, { stop }] of this.running) if (!keys.has(key)) stop.abort();
    this.recent = [...this.recent.filter((key) => !keys.has(key)), ...keys];
    this.forget(keys);
    this.pump();
  }

  close(): void {
    this.want([]);
  }

  private change(key: string, members: Partial<Entry>): void {
    const entries = new Map(this.entries.peek());
    entries.set(key, { ...(entries.get(key) ?? kEmpty), ...members });
    this.entries.value = entries;
  }

  private forget(wanted: Set<string>): void {
    const entries = this.entries.peek();
    let bytes = 0;
    const kept = new Map(entries);
    for (const key of [...this.recent].reverse()) {
      if (wanted.has(key)) continue;
      bytes += entries.get(key)?.image?.data.byteLength ?? 0;
      if (bytes <= kUnwantedBytes && entries.get(key)?.image) continue;
      kept.delete(key);
      this.recent.splice(this.recent.indexOf(key), 1);
    }
    if (kept.size !== entries.size) this.entries.value = kept;
  }

  private pump(): void {
    for (const one of this.wanted) {
      if (this.running.size >= kAtOnce) return;
      const entry = this.entries.peek().get(one.key);
      if (this.running.has(one.key) || (entry && entry.version >= one.version)) continue;
      void this.fetch(one);
    }
  }

  private async fetch({ key, version, fetch }: Wanted): Promise<void> {
    const stop = new AbortController();
    this.running.set(key, { version, stop });
    this.change(key, { loading: true });
    try {
      const fetched = await fetch(stop.signal);
      if (!stop.signal.aborted)
        this.change(key, fetched
          ? { image: fetched.image, flipMean: fetched.flipMean, loading: false, waiting: false, failure: null, version }
          : { loading: false, waiting: true, failure: null, version });
    } catch (failure) {
      if (!stop.signal.aborted) this.change(key, { loading: false, failure: failure as Error, version });
    }
    if (stop.signal.aborted) this.change(key, { loading: false });
    this.running.delete(key);
    this.pump();
  }
}
