// The jobs that match a filter, of which there may be a hundred thousand: the daemon counts them, and rows are fetched in
// pages about what is looked at. Rows are known by their place, newest first; a job that comes or goes shifts the places
// of those below, and what is looked at is then found again by the job it shows.

import { signal } from "@preact/signals";

import type { JobChange, JobSummary, JobSummaryPage } from "../api/types";

export const kPageRows = 100;
const kPagesKept = 60;
const kRequestsAtOnce = 2;
const kLargestPage = 1000;
const kChangesKept = 1000;

export type FetchPage = (offset: number, limit: number, signal: AbortSignal) => Promise<JobSummaryPage>;

/** A row with what an event says of its job. */
export function withChange(row: JobSummary, change: JobChange): JobSummary {
  const next = { ...row };
  if (change.state !== undefined) next.state = change.state;
  if (change.progress !== undefined) next.progress = change.progress;
  if (change.passes_done !== undefined) next.passes_done = change.passes_done;
  if (change.seconds !== undefined) next.seconds = change.seconds;
  if (change.error_now !== undefined) next.error_now = change.error_now;
  if (change.started !== undefined) next.started = change.started;
  if (change.finished !== undefined) next.finished = change.finished;
  if (change.priority !== undefined) next.priority = change.priority;
  if (change.failure !== undefined) next.failure = change.failure?.detail ?? null;
  return next;
}

export class JobList {
  /** Rises when anything that is held has changed. */
  readonly version = signal(0);
  total: number | null = null;
  failure: Error | null = null;
  /** By how much places have shifted since the list began: whoever remembers a place keeps up by it. */
  shifted = 0;

  private readonly rows = new Map<number, JobSummary>();
  private readonly places = new Map<string, number>();
  /** Pages that need not be asked for. Rows of others are shown until they are. */
  private readonly fresh = new Set<number>();
  private readonly asked = new Set<number>();
  private first = 0;
  private last = kPageRows - 1;
  private stop = new AbortController();
  private refreshing: Promise<void> | null = null;
  /** What events told last, and how many they told: an answer that was on its way meanwhile may be older. */
  private recent: JobChange[] = [];
  private told = 0;

  constructor(private readonly fetchPage: FetchPage) {}

  row(place: number): JobSummary | undefined {
    return this.rows.get(place);
  }
  placeOf(id: string): number | undefined {
    return this.places.get(id);
  }
  loaded(): Iterable<JobSummary> {
    return this.rows.values();
  }

  /** Says which places are looked at. */
  look(first: number, last: number): void {
    this.first = Math.max(0, first);
    this.last = Math.max(this.first, last);
    this.pump();
  }

  close(): void {
    this.stop.abort();
  }

  /** Changes the row of a job; false where it is not held. */
  patch(change: JobChange): boolean {
    this.recent.push(change);
    ++this.told;
    if (this.recent.length > 2 * kChangesKept) this.recent = this.recent.slice(-kChangesKept);
    const place = this.places.get(change.id);
    const row = place === undefined ? undefined : this.rows.get(place);
    if (row === undefined) return false;
    this.rows.set(place!, withChange(row, change));
    this.version.value++;
    return true;
  }

  /** Asks anew for what is looked at, and shifts what is held so that jobs keep their rows. */
  refresh(): Promise<void> {
    this.refreshing ??= this.reload().finally(() => (this.refreshing = null));
    return this.refreshing;
  }

  /** Rows of places in order, asked for where they are not held. */
  async range(first: number, last: number): Promise<JobSummary[]> {
    const found: JobSummary[] = [];
    for (let place = first; place <= last; ) {
      const held = this.rows.get(place);
      if (held) {
        found.push(held);
        ++place;
        continue;
      }
      const page = await this.fetchPage(place, Math.min(kLargestPage, last - place + 1), this.stop.signal);
      if (page.items.length === 0) break;
      found.push(...page.items);
      place += page.items.length;
    }
    return found;
  }

  private pagesWanted(): number[] {
    const first = Math.floor(this.first / kPageRows);
    const last = Math.floor(Math.min(this.last, Math.max(0, (this.total ?? Infinity) - 1)) / kPageRows);
    const pages: number[] = [];
    for (let page = first; page <= last; ++page) if (!this.fresh.has(page) && !this.asked.has(page)) pages.push(page);
    return pages;
  }

  /** Asks for pages that are looked at. Who scrolls past many of them waits for none but the last. */
  private pump(): void {
    if (this.failure || this.stop.signal.aborted) return;
    for (const page of this.pagesWanted().slice(0, kRequestsAtOnce - this.asked.size)) void this.load(page);
  }

  private async load(page: number): Promise<void> {
    const stop = this.stop;
    const told = this.told;
    this.asked.add(page);
    try {
      const answer = await this.fetchPage(page * kPageRows, kPageRows, stop.signal);
      if (stop.signal.aborted) return;
      this.asked.delete(page);
      const drifted = this.total !== null && answer.total !== this.total;
      this.put(page * kPageRows, answer.items, told);
      this.fresh.add(page);
      this.total ??= answer.total;
      this.forgetFar();
      this.version.value++;
      // Places have changed under us: what is held belongs elsewhere.
      if (drifted) void this.refresh();
      else this.pump();
    } catch (failure) {
      if (stop.signal.aborted) return;
      this.asked.delete(page);
      this.fail(failure as Error);
    }
  }

  private fail(failure: Error): void {
    this.failure = failure;
    this.version.value++;
  }

  private async reload(): Promise<void> {
    // Answers on their way are of the places as they were.
    this.stop.abort();
    const stop = (this.stop = new AbortController());
    this.asked.clear();
    this.failure = null;
    const anchor = this.anchor();
    try {
      let offset = Math.max(0, this.first - kPageRows / 2);
      const limit = Math.min(kLargestPage, this.last - this.first + 1 + kPageRows);
      let told = this.told;
      let answer = await this.fetchPage(offset, limit, stop.signal);
      const at = () => answer.items.findIndex((job) => job.id === anchor?.id);
      const grown = answer.total - (this.total ?? answer.total);
      if (anchor && at() < 0 && grown !== 0) {
        const guess = Math.max(0, offset + grown);
        const then = this.told;
        const second = await this.fetchPage(guess, limit, stop.signal);
        if (second.items.some((job) => job.id === anchor.id)) [answer, offset, told] = [second, guess, then];
      }
      if (stop.signal.aborted) return;
      const delta = anchor && at() >= 0 ? offset + at() - anchor.place : 0;
      this.shift(delta);
      this.total = answer.total;
      this.fresh.clear();
      this.put(offset, answer.items, told);
      const end = offset + answer.items.length;
      for (let page = Math.ceil(offset / kPageRows); (page + 1) * kPageRows <= end || (end === answer.total && page * kPageRows < end); ++page)
        this.fresh.add(page);
      for (const place of [...this.rows.keys()]) if (place >= answer.total) this.drop(place);
      this.first += delta;
      this.last += delta;
      this.version.value++;
      this.pump();
    } catch (failure) {
      if (!stop.signal.aborted) this.fail(failure as Error);
    }
  }

  /** The first job that is looked at and held. */
  private anchor(): { id: string; place: number } | null {
    for (let place = this.first; place <= this.last; ++place) {
      const row = this.rows.get(place);
      if (row) return { id: row.id, place };
    }
    return null;
  }

  private shift(delta: number): void {
    if (delta === 0) return;
    const rows = [...this.rows];
    this.rows.clear();
    this.places.clear();
    for (const [place, row] of rows) {
      if (place + delta < 0) continue;
      this.rows.set(place + delta, row);
      this.places.set(row.id, place + delta);
    }
    this.shifted += delta;
  }

  private drop(place: number): void {
    const row = this.rows.get(place);
    if (!row) return;
    this.rows.delete(place);
    if (this.places.get(row.id) === place) this.places.delete(row.id);
    this.fresh.delete(Math.floor(place / kPageRows));
  }

  /** Holds rows that were asked for when events had told of `told` changes; what they told since is newer. */
  private put(offset: number, items: JobSummary[], told: number): void {
    const since = told < this.told ? this.recent.slice(told - this.told) : [];
    items.forEach((asked, index) => {
      const job = since.filter(({ id }) => id === asked.id).reduce(withChange, asked);
      const place = offset + index;
      const before = this.places.get(job.id);
      if (before !== undefined && before !== place) this.drop(before);
      const old = this.rows.get(place);
      if (old && old.id !== job.id) this.places.delete(old.id);
      this.rows.set(place, job);
      this.places.set(job.id, place);
    });
  }

  private forgetFar(): void {
    const pages = new Set([...this.rows.keys()].map((place) => Math.floor(place / kPageRows)));
    if (pages.size <= kPagesKept) return;
    const here = Math.floor(this.first / kPageRows);
    const far = [...pages].sort((a, b) => Math.abs(b - here) - Math.abs(a - here)).slice(0, pages.size - kPagesKept / 2);
    for (const page of far) for (let place = page * kPageRows; place < (page + 1) * kPageRows; ++place) this.drop(place);
  }
}
