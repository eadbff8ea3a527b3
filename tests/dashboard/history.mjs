// A data folder in which many jobs have been rendered already (tests/support/many_jobs.py writes it).

import { execFileSync } from "node:child_process";
import { mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { dirname, join, resolve } from "node:path";
import { fileURLToPath } from "node:url";

import { bin } from "./daemon.mjs";
import { after } from "./suite.mjs";

const here = dirname(fileURLToPath(import.meta.url));

/** The folder, removed when the file's tests are over. */
export function historyOf(count) {
  const folder = mkdtempSync(join(tmpdir(), "photond-history-"));
  after(() => rmSync(folder, { recursive: true, force: true }));
  execFileSync("python3", [resolve(here, "../support/many_jobs.py"), folder, String(count)], { env: { ...process.env, PHOTOND_BIN: bin } });
  return folder;
}
