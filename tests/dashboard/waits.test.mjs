// A test's wait ends by what it waits for, or by the death of what would bring it; the test says which.

import assert from "node:assert/strict";

import { openPage, smallJob, startDaemon, suiteOf, test, until } from "./support.mjs";

test("who waits for a daemon that dies says that it died, and the end of its log", async () => {
  const failures = {};
  const context = { test: (name, run) => run().catch(({ message }) => (failures[name] = message)) };
  await suiteOf("dying_daemon").run(new URL("./dying_daemon.mjs", import.meta.url), context, { begin() {}, end() {} });
  assert.deepEqual(Object.keys(failures), ["looks at a page that would change", "asks again and again", "asks once"]);
  for (const said of Object.values(failures)) assert.match(said, /^the daemon died: SIGKILL; the end of its log:\n.*\S/);
});

const daemon = await startDaemon();

test("who looks again and again at a page that is gone is told so", async () => {
  const page = await openPage(daemon, "/jobs");
  await Promise.all([assert.rejects(until(async () => assert.equal(await page.locator(".never").count(), 1)), /has been closed/), page.close()]);
});

test("who waits for a job to run is told that it is over", async () => {
  const { id } = await daemon.run(smallJob());
  await assert.rejects(daemon.running(id), /succeeded/);
});
