// A running photond and a real browser that looks at it, for tests by node's own runner:
//
//   const daemon = await startDaemon();            // stopped when the file's tests are over
//   const page = await openPage(daemon, "/jobs");  // closed likewise; every complaint of the browser fails the test
//   await eventually(async () => assert.equal(await page.locator("li").count(), 2));  // what a page comes to
//   await shoot(page, "jobs-empty");               // a picture to look at, in both themes: $PHOTOND_SCREENSHOTS
//   await axeClean(page);                          // WCAG A and AA, in both themes
//
// The programs are taken from $PHOTOND_BIN. Chromium is Debian's.

import assert from "node:assert/strict";
import { spawn } from "node:child_process";
import { once } from "node:events";
import { mkdirSync, mkdtempSync, readFileSync, rmSync } from "node:fs";
import { createRequire } from "node:module";
import { tmpdir } from "node:os";
import { dirname, join, resolve } from "node:path";
import { after, afterEach, beforeEach } from "node:test";
import { fileURLToPath } from "node:url";

import { chromium } from "playwright-core";

const here = dirname(fileURLToPath(import.meta.url));
export const bin = process.env.PHOTOND_BIN ?? resolve(here, "../../build/bin");
const screenshots = process.env.PHOTOND_SCREENSHOTS ?? resolve(bin, "../dashboard_screenshots");
const axeSource = readFileSync(createRequire(import.meta.url).resolve("axe-core/axe.min.js"), "utf8");

/**
 * How long is waited for what is to come. A machine with two cores that runs several tests at once may take long for it,
 * and only who waits in vain notices how long it is.
 */
export const kPatienceMs = 200_000;

/** What `check` gives once it does not throw any more; when it still does after a long time, its last word stands. */
export async function eventually(check) {
  for (const end = Date.now() + kPatienceMs; ; await new Promise((done) => setTimeout(done, 50))) {
    try {
      return await check();
    } catch (failure) {
      if (Date.now() > end) throw failure;
    }
  }
}

const kChromiumArguments = [
  "--no-sandbox",
  "--disable-gpu",
  "--use-gl=angle",
  "--use-angle=swiftshader",
  "--enable-unsafe-swiftshader",
  "--disable-quic",
  "--disable-background-networking",
  "--disable-component-update",
  "--disable-sync",
  "--no-first-run",
];

/** Runs when the file's tests are over, last come first. */
const closing = [];
after(async () => {
  for (const close of closing.reverse()) await close();
});

/** Contexts of pages that the test which runs has opened: they end with it, for a page goes on drawing. */
let ofTest = null;
beforeEach(() => {
  ofTest = [];
});
afterEach(async () => {
  for (const context of ofTest) await context.close();
  ofTest = null;
});

// --- the daemon

class Daemon {
  constructor(url, process, data) {
    this.url = url;
    this.process = process;
    this.data = data;
  }

  /** The JSON of an answer; an answer of 400 or more fails. */
  async json(method, path, body, headers = {}) {
    const answer = await fetch(this.url + path, {
      method,
      headers: { ...(body === undefined ? {} : { "Content-Type": "application/json" }), ...headers },
      body: body === undefined ? undefined : JSON.stringify(body),
    });
    const text = await answer.text();
    assert.ok(answer.ok, `${method} ${path}: ${answer.status} ${text}`);
    return JSON.parse(text);
  }

  get = (path) => this.json("GET", path);
  submit = (job) => this.json("POST", "/v1/jobs", job);

  /** The job once it is over. */
  async finished(id) {
    for (;;) {
      const job = await this.get(`/v1/jobs/${id}`);
      if (!["queued", "running"].includes(job.state)) return job;
      await new Promise((done) => setTimeout(done, 50));
    }
  }

  /** The job once it runs. */
  running(id) {
    return eventually(async () => {
      const job = await this.get(`/v1/jobs/${id}`);
      assert.equal(job.state, "running");
      return job;
    });
  }

  /** Cancels what a test has left queued or running: a test that fails midway must not take the next one along. */
  async idle() {
    if (this.process.exitCode !== null || this.process.signalCode !== null) return;
    const left = (await this.get("/v1/jobs?view=summary&state=queued,running&limit=1000")).items;
    for (const { id } of left) await fetch(`${this.url}/v1/jobs/${id}`, { method: "DELETE" }).then((answer) => answer.arrayBuffer());
    for (const { id } of left) await eventually(async () => assert.ok(!["queued", "running"].includes(await this.stateOf(id)), `${id} goes on`));
  }

  /** Null for a job that is not there any more. */
  async stateOf(id) {
    const answer = await fetch(`${this.url}/v1/jobs/${id}`);
    const { state } = await answer.json();
    return answer.ok ? state : null;
  }

  /** Submits a job and gives it once it has succeeded. */
  async run(job) {
    const done = await this.finished((await this.submit(job)).id);
    assert.equal(done.state, "succeeded", JSON.stringify(done.failure));
    return done;
  }

  async stop(signal = "SIGTERM") {
    if (this.process.exitCode !== null || this.process.signalCode !== null) return;
    const ended = once(this.process, "exit");
    this.process.kill(signal);
    await ended;
  }
}

/** A job that takes a fraction of a second. */
export const smallJob = (more = {}) => ({
  scene: "cornell-box",
  image: { width: 48, height: 48 },
  method: { name: "path_tracing" },
  stop: { passes: 2 },
  ...more,
});

/**
 * A daemon on a free port of loopback, its workers ready. `data`: a folder to keep the data in (else a fresh one, removed
 * at the end); `listen`: such as "127.0.0.1:8123"; `arguments`: more for its command line.
 */
export async function startDaemon({ data, listen = "127.0.0.1:0", arguments: more = [] } = {}) {
  const folder = data ?? mkdtempSync(join(tmpdir(), "photond-dashboard-"));
  const child = spawn(join(bin, "photond"), ["--data", folder, "--listen", listen, "--repeats", "0", ...more], { stdio: ["ignore", "pipe", "pipe"] });
  let log = "";
  child.stderr.on("data", (chunk) => (log = (log + chunk).slice(-20_000)));
  let said = "";
  const url = await new Promise((found, lost) => {
    child.stdout.on("data", (chunk) => {
      said += chunk;
      const line = /photond listening on (http:\/\/\S+)/.exec(said);
      if (line) found(line[1]);
    });
    child.on("exit", (code) => lost(new Error(`photond ended with ${code}\n${log}`)));
  });
  const daemon = new Daemon(url, child, folder);
  closing.push(async () => {
    await daemon.stop();
    if (!data) rmSync(folder, { recursive: true, force: true });
  });
  for (;;) {
    const ready = await fetch(`${url}/readyz`);
    await ready.arrayBuffer();
    if (ready.ok) return daemon;
    await new Promise((done) => setTimeout(done, 20));
  }
}

// --- the browser

let started;
/** The file's one browser. */
export function browser() {
  started ??= chromium.launch({ executablePath: "/usr/bin/chromium", args: kChromiumArguments, timeout: 2 * kPatienceMs }).then((found) => {
    closing.push(() => found.close());
    return found;
  });
  return started;
}

/** Options of openPage(). */
export const kTelephone = { width: 390, height: 844, finger: true };

const WAITING_PICTURE = /status of 503.*\/scenes\/[^/]+\/(thumbnail|preview)\.png/;

/**
 * A page of the dashboard, closed with the test that opens it, else with the file. What the browser complains of (an exception, a console error, a violated content security
 * policy, a file that is not there) is in page.complaints, and axeClean() and expectNoComplaints() fail by it. `expected`: a pattern of
 * complaints that belong to the test, such as of requests that are to be refused. A scene's picture that waits for a running job
 * (503, which the page asks for again) belongs to every test: the console names each. `finger`: of a device on which a
 * finger points and nothing hovers.
 */
export async function openPage(daemon, path = "/", { width = 1440, height = 900, theme = "light", expected = null, finger = false } = {}) {
  const context = await (await browser()).newContext({ viewport: { width, height }, colorScheme: theme, reducedMotion: "reduce", acceptDownloads: true, hasTouch: finger, isMobile: finger });
  ofTest?.push(context);
  await context.grantPermissions(["clipboard-read", "clipboard-write"], { origin: daemon.url });
  const page = await context.newPage();
  page.setDefaultTimeout(kPatienceMs);
  page.complaints = [];
  const complain = (text) => {
    if (!expected?.test(text) && !WAITING_PICTURE.test(text)) page.complaints.push(text);
  };
  page.on("pageerror", (error) => complain(`exception: ${error.stack ?? error.message}`));
  page.on("console", (message) => {
    if (message.type() === "error") complain(`console: ${message.text()} (${message.location().url})`);
  });
  await page.goto(daemon.url + path);
  return page;
}

/** Waits until nothing of the page is wider than its window. */
export async function fitsItsWidth(page) {
  const { width } = page.viewportSize();
  await eventually(async () => {
    const wide = await page.evaluate(() => document.documentElement.scrollWidth);
    assert.ok(wide <= width, `the page scrolls sideways: ${wide} pixels in ${width}`);
  });
}

/** Fails by whatever the browser has complained of on this page. */
export function expectNoComplaints(page) {
  assert.deepEqual(page.complaints, []);
}

const kRules = ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "best-practice"];

/** Runs `look` in the light and in the dark. */
async function inBothThemes(page, look) {
  for (const theme of ["light", "dark"]) {
    await page.emulateMedia({ colorScheme: theme, reducedMotion: "reduce" });
    await page.waitForFunction((wanted) => document.documentElement.dataset.theme === wanted, theme);
    await look(theme);
  }
  await page.emulateMedia({ colorScheme: "light", reducedMotion: "reduce" });
}

/** Keeps pictures of the page, light and dark, to be looked at. */
export async function shoot(page, name, options = {}) {
  mkdirSync(screenshots, { recursive: true });
  await inBothThemes(page, (theme) => page.screenshot({ path: join(screenshots, `${name}-${theme}.png`), ...options }));
}

/**
 * Fails by every rule of WCAG 2 A and AA that axe sees broken, and by complaints of the browser. Themes differ in colour
 * alone: the other one is held to the rule on contrast.
 */
export async function axeClean(page, { exclude = [] } = {}) {
  await inBothThemes(page, async (theme) => {
    // By the debugger, not as a script of the page: its policy would not have it.
    await page.evaluate(`if (!window.axe) { ${axeSource} }`);
    const found = await page.evaluate(
      ({ without, rules }) =>
        window.axe.run(without.length ? { exclude: without } : document, { runOnly: rules }).then((result) =>
          result.violations.map((rule) => `${rule.id}: ${rule.help}\n${rule.nodes.slice(0, 4).map((node) => `    ${node.html.slice(0, 160)}\n      ${node.failureSummary.replaceAll("\n", " ")}`).join("\n")}`),
        ),
      { without: exclude, rules: theme === "light" ? kRules : ["color-contrast"] },
    );
    assert.deepEqual(found, [], `${page.url()} in the ${theme} theme`);
  });
  expectNoComplaints(page);
}
