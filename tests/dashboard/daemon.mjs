// A running photond, and what is asked of it. The programs are taken from $PHOTOND_BIN.

import assert from "node:assert/strict";
import { spawn } from "node:child_process";
import { once } from "node:events";
import { closeSync, mkdirSync, mkdtempSync, openSync, readFileSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { dirname, join, resolve } from "node:path";
import { fileURLToPath } from "node:url";

import { suite } from "./suite.mjs";

const here = dirname(fileURLToPath(import.meta.url));
export const bin = process.env.PHOTOND_BIN ?? resolve(here, "../../build/bin");

const kLinesOfLog = 40;
const goesOn = ({ state }) => state === "queued" || state === "running";

class Daemon {
  /** Whether its end is wanted: then nobody's test fails by it. */
  #ends = false;
  #lifeline;

  /** Starts one, whose log goes to a file; `lifeline` is cut when it dies. */
  constructor(lifeline, data, log, more) {
    this.#lifeline = lifeline;
    this.data = data;
    const file = openSync(log, "a");
    this.process = spawn(join(bin, "photond"), ["--data", data, "--repeats", "0", "--threads", "1", ...more], { stdio: ["ignore", "pipe", file] });
    closeSync(file);
    this.ended = once(this.process, "exit").then(([code, signal]) => {
      const end = readFileSync(log, "utf8").trimEnd().split("\n").slice(-kLinesOfLog).join("\n");
      if (!this.#ends) lifeline.lose(new Error(`the daemon died: ${signal ?? `exit status ${code}`}; the end of its log:\n${end}`));
    });
    let said = "";
    this.listening = new Promise((found) =>
      this.process.stdout.on("data", (chunk) => {
        said += chunk;
        const line = /photond listening on (http:\/\/\S+)/.exec(said);
        if (line) found(line[1]);
      }),
    );
  }

  /** Waits until its workers are ready. */
  async ready() {
    this.url = await this.listening;
    await this.#lifeline.until(async () => {
      const answer = await fetch(`${this.url}/readyz`);
      await answer.arrayBuffer();
      assert.ok(answer.ok, "the daemon is not ready yet");
    });
  }

  get isOver() {
    return this.process.exitCode !== null || this.process.signalCode !== null;
  }

  /** Comes back while it answers; where it takes no connection any more, once it is gone. */
  async probe() {
    if (this.#ends || !this.url) return;
    try {
      await (await fetch(`${this.url}/readyz`)).arrayBuffer();
    } catch {
      await this.ended;
    }
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
  cancel = (id) => this.json("DELETE", `/v1/jobs/${id}`);

  /** A job, a comparison or a sequence at its path, once it is over. */
  over(path) {
    return this.#lifeline.until(async () => {
      const record = await this.get(path);
      assert.ok(!goesOn(record), `${path} is ${record.state}`);
      return record;
    });
  }

  /** The job once it is over. */
  finished = (id) => this.over(`/v1/jobs/${id}`);

  /** What is at a path once it has succeeded. */
  async succeeds(path) {
    const done = await this.over(path);
    assert.equal(done.state, "succeeded", `${path}: ${JSON.stringify(done.failure ?? null)}`);
    return done;
  }

  /** The job once it runs and has done so many passes; one that is over before fails. */
  async running(id, passes = 0) {
    const job = await this.#lifeline.until(async () => {
      const found = await this.get(`/v1/jobs/${id}`);
      assert.ok(!goesOn(found) || (found.state === "running" && found.passes_done >= passes), `${id} is ${found.state} after ${found.passes_done} passes`);
      return found;
    });
    assert.equal(job.state, "running", JSON.stringify(job.failure ?? null));
    return job;
  }

  /** Cancels what a test has left queued or running: a test that fails midway must not take the next one along. */
  async idle() {
    if (this.isOver) return;
    const left = (await this.get("/v1/jobs?view=summary&state=queued,running&limit=1000")).items;
    for (const { id } of left) await fetch(`${this.url}/v1/jobs/${id}`, { method: "DELETE" }).then((answer) => answer.arrayBuffer());
    for (const { id } of left) await this.#lifeline.until(async () => assert.ok(!["queued", "running"].includes(await this.stateOf(id)), `${id} goes on`));
  }

  /** Null for a job that is not there any more. */
  async stateOf(id) {
    const answer = await fetch(`${this.url}/v1/jobs/${id}`);
    const { state } = await answer.json();
    return answer.ok ? state : null;
  }

  /** Submits a job and gives it once it has succeeded. */
  async run(job) {
    return this.succeeds(`/v1/jobs/${(await this.submit(job)).id}`);
  }

  /** Uploads a .glb, and gives the scene. */
  async upload(name, body) {
    const answer = await fetch(`${this.url}/v1/scenes?name=${name}`, { method: "POST", headers: { "Content-Type": "model/gltf-binary" }, body });
    const text = await answer.text();
    assert.equal(answer.status, 201, text);
    return JSON.parse(text);
  }

  async stop(signal = "SIGTERM") {
    this.#ends = true;
    if (!this.isOver) this.process.kill(signal);
    await this.ended;
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
 * A daemon on a free port of loopback, its workers ready; it ends with the file's tests. `data`: a folder to keep the data
 * in (else a fresh one, removed at the end); `listen`: such as "127.0.0.1:8123"; `arguments`: more for its command line.
 * Its worker has one thread: what it renders while pages are looked at is paid for and not waited for.
 */
export async function startDaemon({ data, listen = "127.0.0.1:0", arguments: more = [] } = {}) {
  const home = mkdtempSync(join(tmpdir(), "photond-dashboard-"));
  const { lifeline, closing, probes } = suite();
  mkdirSync(join(home, "data"));
  const daemon = new Daemon(lifeline, data ?? join(home, "data"), join(home, "log"), ["--listen", listen, ...more]);
  probes.push(() => daemon.probe());
  closing.push(async () => {
    await daemon.stop();
    rmSync(home, { recursive: true, force: true });
  });
  await daemon.ready();
  return daemon;
}
