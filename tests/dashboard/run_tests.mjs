// Runs the files of tests of the dashboard, one after the other, by one browser.
//
//   node run_tests.mjs               all
//   node run_tests.mjs compare now   compare.test.mjs and now.test.mjs
//   node run_tests.mjs --list        prints their names
//
//   PHOTOND_BIN=FOLDER           where photond is; build/bin by itself
//   PHOTOND_SCREENSHOTS=FOLDER   keeps pictures of the pages there, to be looked at
//   PHOTOND_TEST_CASES=FILE      runs only the files that a line of FILE names (tests/support/select_cases.py)
//   PHOTOND_TEST_TIMES=FOLDER    adds a line for each case to a file there: processor seconds, tab, FILE.CASE

import { appendFileSync, readdirSync, readFileSync } from "node:fs";
import { dirname, join } from "node:path";
import { test } from "node:test";
import { fileURLToPath, pathToFileURL } from "node:url";

import { closeBrowser } from "./browser.mjs";
import { processorSeconds } from "./processor_seconds.mjs";
import { suiteOf } from "./suite.mjs";

const here = dirname(fileURLToPath(import.meta.url));
const kEnd = ".test.mjs";
const all = readdirSync(here).filter((file) => file.endsWith(kEnd)).map((file) => file.slice(0, -kEnd.length)).sort();

/** Those that the command line names, or $PHOTOND_TEST_CASES, which has cases of other programs too. */
function chosen() {
  const asked = process.argv.slice(2);
  const unknown = asked.filter((name) => !all.includes(name));
  if (unknown.length) throw new Error(`there is no ${unknown.join(", ")}; there are ${all.join(", ")}`);
  if (asked.length) return asked;
  const file = process.env.PHOTOND_TEST_CASES;
  if (!file) return all;
  const named = readFileSync(file, "utf8").split("\n");
  const found = all.filter((name) => named.includes(name));
  if (!found.length) throw new Error(`PHOTOND_TEST_CASES=${file} names no file of the dashboard's`);
  return found;
}

/** Notes what each case costs, its daemons and its browser included. */
const times = process.env.PHOTOND_TEST_TIMES;
const costs = {
  begin: () => (times ? processorSeconds() : 0),
  end: (begun, name) => times && appendFileSync(join(times, `dashboard.${process.pid}.cases`), `${(processorSeconds() - begun).toFixed(2)}\t${name}\n`),
};

if (process.argv.includes("--list")) console.log(all.join("\n"));
else {
  const names = chosen();
  for (const name of names)
    test(name, async (context) => {
      try {
        await suiteOf(name).run(pathToFileURL(join(here, name + kEnd)), context, costs);
      } finally {
        if (name === names.at(-1)) await closeBrowser();
      }
    });
}
