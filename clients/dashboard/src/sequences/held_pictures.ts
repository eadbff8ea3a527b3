// Which pictures of a sequence's frames a page holds, which are still to be fetched, and which it has given up.

/** Of one sequence: what a page can hold. */
export const kMostPictures = 1000;
/** How often a picture is asked for. */
export const kMostTries = 3;

/** The picture of a frame, by its job; null where there is none yet. */
export type FetchPicture = (id: string) => Promise<Blob | null>;

export class HeldPictures {
  /** URLs for <img> by the frame's job. */
  readonly urls = new Map<string, string>();
  private listed = new Set<string>();
  private readonly failures = new Map<string, number>();

  /** The frames that have pictures, by their jobs: of those that are none of them any more the URLs go. */
  list(ids: string[]): void {
    this.listed = new Set(ids.slice(0, kMostPictures));
    for (const [id, url] of this.urls)
      if (!this.listed.has(id)) {
        URL.revokeObjectURL(url);
        this.urls.delete(id);
      }
    for (const id of this.failures.keys()) if (!this.listed.has(id)) this.failures.delete(id);
  }

  /** More than a page holds: it is not asked for. */
  isLeftOut(id: string): boolean {
    return !this.listed.has(id);
  }

  isGivenUp(id: string): boolean {
    return (this.failures.get(id) ?? 0) >= kMostTries;
  }

  missing(): string[] {
    return [...this.listed].filter((id) => !this.urls.has(id) && !this.isGivenUp(id));
  }

  /**
   * Fetches what is missing, one after the other; what fails once more when all others are there, after a pause, until it
   * is given up. `changed` after each. Ends when `signal` says that another list has come, or that nobody looks any more.
   */
  async fetchMissing(fetch: FetchPicture, pause: () => Promise<void>, changed: () => void, signal: AbortSignal): Promise<void> {
    for (let ids = this.missing(); ids.length > 0; ids = this.missing()) {
      for (const id of ids) {
        const blob = await fetch(id).catch(() => null);
        if (signal.aborted) return;
        if (blob) this.urls.set(id, URL.createObjectURL(blob));
        else this.failures.set(id, (this.failures.get(id) ?? 0) + 1);
        changed();
      }
      if (this.missing().length > 0) await pause().catch(() => undefined);
      if (signal.aborted) return;
    }
  }
}
