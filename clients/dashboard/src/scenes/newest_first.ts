// Pictures of a view that moves: one is asked for at a time, and then the newest that is wanted, whatever was wanted in
// between. Waiting for every view would leave the hand behind; asking for all at once would queue them in the daemon.

export interface Outcome<Wish, Answer> {
  wish: Wish;
  answer?: Answer;
  failure?: Error;
  milliseconds: number;
}

export class NewestFirst<Wish, Answer> {
  private busy = false;
  private next: Wish | null = null;
  private readonly stopper = new AbortController();

  constructor(
    private readonly ask: (wish: Wish, signal: AbortSignal) => Promise<Answer>,
    private readonly tell: (outcome: Outcome<Wish, Answer>) => void,
  ) {}

  /** Takes the place of what waits; what is under way comes to its end. */
  want(wish: Wish): void {
    this.next = wish;
    if (!this.busy) void this.run();
  }

  /** Whether there is a newer wish than the one under way, or told of. */
  get waits(): boolean {
    return this.next !== null;
  }

  /** Nothing is told any more. */
  stop(): void {
    this.next = null;
    this.stopper.abort();
  }

  private async run(): Promise<void> {
    this.busy = true;
    while (this.next !== null) {
      const wish = this.next;
      this.next = null;
      const begun = performance.now();
      const outcome: Outcome<Wish, Answer> = { wish, milliseconds: 0 };
      try {
        outcome.answer = await this.ask(wish, this.stopper.signal);
      } catch (failure) {
        outcome.failure = failure as Error;
      }
      if (this.stopper.signal.aborted) return;
      outcome.milliseconds = performance.now() - begun;
      this.tell(outcome);
    }
    this.busy = false;
  }
}
