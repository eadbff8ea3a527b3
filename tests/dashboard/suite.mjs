// A file of tests within the program that runs all of them (run_tests.mjs): its cases, what ends with them, and its waits.
//
//   test("what holds", async () => { ... });      // the cases run in order, once the file has been read
//   afterEach(() => daemon.idle());               // after each of them
//   after(() => rmSync(folder, ...));             // when the last is over, last come first
//   await until(async () => assert.equal(await page.locator("li").count(), 2));
//
// A wait has no end of its own: a busy machine may stretch it. It ends by what it waits for, or by the death of what would
// bring it, a daemon, a page or the browser, which the test then names. ctest alone says when a run has taken too long.

import { setTimeout as pause } from "node:timers/promises";

const kBetweenLooksMs = 50;
const kNoteAfterMs = 60_000;
/** What looking again does not mend: a page that is gone, as Playwright says it, and a fault of the test's own. */
const isFinal = (failure) => failure instanceof ReferenceError || /has been closed|crashed/.test(failure.message);

/** What has to live for a test to get done. When a part of it dies, all that waits fails, and says which part it was. */
export class Lifeline {
  /** Why it is cut; null while all of it lives. */
  lost = null;
  /** Why the wait that goes on has not ended yet: the last that its check has thrown. */
  waitsFor = null;
  #cut;
  #end = new Promise((_, fail) => (this.#cut = fail));

  constructor() {
    this.#end.catch(() => {});
  }

  lose(failure) {
    this.lost ??= failure;
    this.#cut(failure);
  }

  /** What `work` comes to, unless something dies first. */
  async during(work) {
    if (this.lost) throw this.lost;
    return Promise.race([this.#end, work()]);
  }

  /** What `check` gives once it does not throw any more; fails when its page is gone. */
  async until(check) {
    for (;;) {
      if (this.lost) throw this.lost;
      try {
        const found = await check();
        this.waitsFor = null;
        return found;
      } catch (failure) {
        if (isFinal(failure)) throw failure;
        this.waitsFor = failure;
      }
      await pause(kBetweenLooksMs);
    }
  }
}

/** The cases of one file, and what they have opened. */
class Suite {
  lifeline = new Lifeline();
  cases = [];
  afterEach = [];
  /** Closed when the file is over, last come first. */
  closing = [];
  /** Closed with the case that runs; null between cases. */
  ofCase = null;
  /** Functions that find out whether something has died of which nobody has told yet. */
  probes = [];

  constructor(name) {
    this.name = name;
  }

  /**
   * Reads the file, runs its cases and closes what it has opened. `context` is node's, of the test that the file is; `costs`
   * notes what each case costs.
   */
  async run(file, context, costs) {
    const before = current;
    current = this;
    try {
      await this.#attempts("the file's own start", [() => import(file)]);
      for (const { name, run } of this.cases)
        await context.test(name, async (ofCase) => {
          this.ofCase = [];
          const begun = costs.begin();
          try {
            await this.#attempts(name, [() => run(ofCase), ...this.afterEach]);
          } finally {
            const opened = this.ofCase;
            this.ofCase = null;
            await this.#close(opened);
            costs.end(begun, `${this.name}.${name}`);
          }
        });
    } finally {
      await this.#close(this.closing);
      current = before;
    }
  }

  /** Last come first. What does not close because something has died is not what is the matter. */
  async #close(opened) {
    for (const close of opened.reverse())
      try {
        await close();
      } catch (failure) {
        if (!this.lifeline.lost) throw failure;
      }
  }

  /** Does one after the other, though one fails; fails by the first failure, or by the death that is behind it. */
  async #attempts(what, works) {
    const note = setInterval(() => this.#say(what), kNoteAfterMs).unref();
    const failures = [];
    try {
      for (const work of works)
        try {
          await this.lifeline.during(work);
        } catch (failure) {
          failures.push(failure);
        }
      if (!failures.length) return;
      // Who asks a daemon that dies hears of a broken connection before its parent hears of its end.
      for (const probe of this.probes) await probe();
    } finally {
      clearInterval(note);
    }
    const [first] = failures;
    const { lost } = this.lifeline;
    throw lost && lost !== first ? new Error(`${lost.message}\nseen as: ${first.stack ?? first}`) : first;
  }

  /** A sign of life of a test that takes long: where its time-out ends it, this is the last that is known of it. */
  #say(what) {
    const { waitsFor } = this.lifeline;
    console.error(`# ${this.name}: "${what}" goes on${waitsFor ? `; it waits: ${waitsFor.message}` : ""}`);
  }
}

let current = null;
/** The file whose cases run. */
export const suite = () => current;
export const suiteOf = (name) => new Suite(name);

export function test(name, run) {
  current.cases.push({ name, run });
}

export function afterEach(run) {
  current.afterEach.push(run);
}

export function after(run) {
  current.closing.push(run);
}

/** What `check` gives once it does not throw any more. */
export const until = (check) => current.lifeline.until(check);
