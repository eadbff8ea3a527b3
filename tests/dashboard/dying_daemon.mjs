// Tests whose daemon dies while they wait for it: what they say of it is judged by waits.test.mjs.

import assert from "node:assert/strict";

import { afterEach, openPage, startDaemon, test, until } from "./support.mjs";

const daemon = await startDaemon();
afterEach(() => daemon.idle());

test("looks at a page that would change", async () => {
  const page = await openPage(daemon, "/jobs", { expected: /ERR_/ });
  await page.getByText("Nothing has been rendered yet.").waitFor();
  daemon.process.kill("SIGKILL");
  await page.getByText("This will never be there.").waitFor();
});

test("asks again and again", () => until(async () => assert.equal((await daemon.get("/v1/jobs")).total, 1)));

test("asks once", () => daemon.get("/v1/jobs"));
