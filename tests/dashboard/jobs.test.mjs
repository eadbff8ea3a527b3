// The Jobs page over a long history: found, read, steered, one job or all at once.
// PHOTOND_MANY_JOBS=100000 measures it over the history that the page is made for.

import assert from "node:assert/strict";
import { test } from "node:test";

import { historyOf } from "./history.mjs";
import { axeClean, expectNoComplaints, openPage, shoot, smallJob, startDaemon } from "./support.mjs";

const kJobs = Number(process.env.PHOTOND_MANY_JOBS ?? 4000);
const daemon = await startDaemon({ data: historyOf(kJobs) });
// Made-up jobs have no films, so there is no picture of them where one is opened or compared for long enough.
const page = await openPage(daemon, "/jobs", { expected: /ERR_CONNECTION_REFUSED|ERR_INCOMPLETE_CHUNKED|ERR_EMPTY_RESPONSE|ERR_CONNECTION_RESET|status of 409|status of 404.*\/(preview\.png|pixels\?)/ });

const grid = page.getByRole("grid");
const rowOf = (id) => grid.getByRole("row").filter({ has: page.getByRole("link", { name: id, exact: true }) });
const total = () => grid.getAttribute("aria-rowcount").then((count) => Number(count) - 1);
const matching = (count) => page.waitForFunction((wanted) => document.querySelector("[role=grid]").getAttribute("aria-rowcount") === String(wanted + 1), count);
const loaded = () => page.waitForFunction(() => document.querySelectorAll(".jobs-space .jobs-row").length > 0 && !document.querySelector(".jobs-row.waits"));
const shownIds = () => page.$$eval(".jobs-space .jobs-row .jobs-job a", (links) => links.map((link) => link.textContent));
const activeId = () => page.evaluate(() => document.getElementById(document.querySelector("[role=grid]").getAttribute("aria-activedescendant"))?.querySelector("a")?.textContent);
/** The active row is drawn a frame after the key that made it active. */
const becomesActive = (id) => page.waitForFunction((wanted) => document.getElementById(document.querySelector("[role=grid]").getAttribute("aria-activedescendant"))?.querySelector("a")?.textContent === wanted, id);
async function go(path) {
  await page.goto(daemon.url + path);
  await loaded();
}

test("is usable within a second over a long history", async () => {
  await loaded();
  const times = [];
  for (let i = 0; i < 3; ++i) {
    await page.goto(`${daemon.url}/jobs`);
    await loaded();
    times.push(await page.evaluate(() => performance.now()));
  }
  console.log(`# ${kJobs} jobs: usable after ${times.map((time) => time.toFixed(0)).join(", ")} ms`);
  assert.equal(await total(), kJobs);
  assert.ok(Math.min(...times) < 1000, `usable after ${times} ms`);
  await becomesActive(`J${kJobs}`);
});

test("scrolls by fetching what is looked at, and draws little meanwhile", async () => {
  const frames = await page.evaluate(async () => {
    const grid = document.querySelector("[role=grid]");
    const frame = () => new Promise((done) => requestAnimationFrame(done));
    const measure = async (steps, move) => {
      const times = [];
      let last = performance.now();
      for (let i = 0; i < steps; ++i) {
        move(i / steps);
        await frame();
        times.push(performance.now() - last);
        last = performance.now();
      }
      times.sort((a, b) => a - b);
      return { median: times[times.length >> 1], p95: times[Math.floor(times.length * 0.95)], rows: document.querySelectorAll(".jobs-space .jobs-row").length };
    };
    const wheel = await measure(90, () => (grid.scrollTop += 240));
    const drag = await measure(90, (share) => (grid.scrollTop = share * (grid.scrollHeight - grid.clientHeight)));
    return { wheel, drag };
  });
  console.log(`# frames, ms: wheel median ${frames.wheel.median.toFixed(1)} p95 ${frames.wheel.p95.toFixed(1)}, scrollbar median ${frames.drag.median.toFixed(1)} p95 ${frames.drag.p95.toFixed(1)}`);
  assert.ok(frames.drag.rows < 80, "only rows in view are there");
  assert.ok(frames.wheel.median < 50, `a frame takes ${frames.wheel.median} ms`);
  await grid.press("End");
  await loaded();
  await becomesActive("J1");
  const last = rowOf("J1");
  assert.equal(await last.getAttribute("aria-rowindex"), String(kJobs + 1));
});

test("is read and picked by keys", async () => {
  await page.keyboard.press("Home");
  await loaded();
  await page.keyboard.press("j");
  await page.keyboard.press("ArrowDown");
  await page.keyboard.press("k");
  await becomesActive(`J${kJobs - 1}`);
  await page.keyboard.press("x");
  await page.keyboard.press("Shift+ArrowDown");
  await page.keyboard.press("Shift+ArrowDown");
  await page.getByText("3 jobs selected").waitFor();
  await page.keyboard.press("Shift+ArrowUp");
  await page.getByText("2 jobs selected").waitFor();
  assert.equal(await grid.locator("[aria-selected=true]").count(), 2);
  await shoot(page, "jobs");
  await axeClean(page);
  await page.keyboard.press("v");
  await page.waitForURL(/\/compare\?/);
  assert.match(decodeURIComponent(page.url()), new RegExp(`images=job:J${kJobs - 1},job:J${kJobs - 2}`));
  await page.goBack();
  await loaded();
});

test("opens a job and comes back to the place", async () => {
  await page.evaluate(() => (document.querySelector("[role=grid]").scrollTop = 20_000));
  await loaded();
  await page.waitForTimeout(100);
  const before = await shownIds();
  await grid.locator(".jobs-space .jobs-row").nth(12).locator(".jobs-scene").click();
  const id = await activeId();
  await grid.focus();
  await page.keyboard.press("Enter");
  await page.waitForURL(`**/jobs/${id}`);
  await page.goBack();
  await loaded();
  await page.waitForFunction((wanted) => document.querySelector(`.jobs-job a[href="/jobs/${wanted}"]`), id);
  assert.deepEqual((await shownIds()).slice(10, 20), before.slice(10, 20));
  await becomesActive(id);
});

test("is filtered by words, with suggestions, and by its address", async () => {
  await go("/jobs");
  await page.keyboard.press("/");
  await page.keyboard.type("stat");
  await page.keyboard.press("ArrowDown");
  await page.keyboard.press("Enter");
  await page.waitForFunction(() => document.querySelector("#jobs-filter").value === "state:");
  await page.keyboard.type("fai");
  await page.keyboard.press("ArrowDown");
  await page.keyboard.press("Enter");
  await page.waitForURL(/\?state=failed$/);
  const failed = (await daemon.get("/v1/jobs?view=summary&state=failed&limit=1")).total;
  await matching(failed);
  await loaded();
  assert.equal(await grid.locator(".state:not(.failed)").count(), 0);
  await shoot(page, "jobs-failed");
  await page.keyboard.type("method:path_tracing ");
  const both = (await daemon.get("/v1/jobs?view=summary&state=failed&method=path_tracing&limit=1")).total;
  await matching(both);
  assert.ok(both < failed);
  // The chips count what matches the other words.
  await page.getByRole("button", { name: /^failed/, pressed: true }).waitFor();
  await go("/jobs?method=path_tracing&state=failed");
  assert.equal(await total(), both);
  assert.equal(await page.locator("#jobs-filter").inputValue(), "state:failed method:path_tracing");
  await page.locator("#jobs-filter").fill("state:nonsense");
  await page.keyboard.press("Escape");
  await page.getByText("“nonsense” is none of queued, running, succeeded, failed, cancelled").waitFor();
  await page.locator("#jobs-filter").fill("J2 J3");
  await matching(2);
  await page.locator("#jobs-filter").fill("label:no=such");
  await page.getByText("No job matches.").waitFor();
  await page.getByRole("button", { name: "Show all jobs" }).click();
  await matching(kJobs);
});

test("new jobs come on top and leave what is read in its place", async () => {
  await go("/jobs");
  await page.evaluate(() => (document.querySelector("[role=grid]").scrollTop = 7200));
  await loaded();
  await page.waitForTimeout(200);
  const placeOf = (id) => page.evaluate((wanted) => document.querySelector(`.jobs-job a[href="/jobs/${wanted}"]`)?.getBoundingClientRect().top, id);
  const read = (await shownIds())[15];
  const before = await placeOf(read);
  const job = await daemon.run(smallJob());
  await page.getByRole("button", { name: /1 new job/ }).click({ trial: true });
  assert.ok(Math.abs((await placeOf(read)) - before) < 1, "the row that was read has moved");
  await page.getByRole("button", { name: /1 new job/ }).click();
  await rowOf(job.id).getByText("succeeded").waitFor();
  assert.equal(await total(), kJobs + 1);
  // And a job that is watched changes where it stands.
  const long = await daemon.submit(smallJob({ image: { width: 128, height: 128 }, stop: { seconds: 60 } }));
  await rowOf(long.id).getByText("running").waitFor();
  await grid.focus();
  await page.keyboard.press("Home");
  await page.keyboard.press("c");
  await rowOf(long.id).getByText("cancelled").waitFor();
});

test("many jobs are cancelled, given another priority, retried and removed, and what fails is said", async () => {
  const labels = { bulk: "yes" };
  const ids = [];
  for (let i = 0; i < 6; ++i) ids.push((await daemon.submit(smallJob({ image: { width: 128, height: 128 }, stop: { seconds: 120 }, labels }))).id);
  await go("/jobs?label=bulk%3Dyes");
  assert.equal(await total(), 6);
  // One by its key.
  await grid.focus();
  await page.keyboard.press("+");
  await page.getByText(`${ids[5]} has priority 10.`).waitFor();
  assert.equal((await daemon.get(`/v1/jobs/${ids[5]}`)).request.priority, 10);
  await rowOf(ids[5]).getByText("+10").waitFor();
  // All that match.
  await page.getByRole("button", { name: "Select all 6" }).click();
  await page.getByText("6 jobs selected").waitFor();
  await page.getByRole("button", { name: "Priority" }).click();
  const dialog = page.getByRole("dialog");
  await dialog.getByLabel("Priority").fill("-20");
  await dialog.getByRole("button", { name: "Change the priority of 6 jobs" }).click();
  await page.getByText("6 jobs given that priority.").waitFor();
  for (const id of ids) assert.equal((await daemon.get(`/v1/jobs/${id}`)).request.priority, -20);
  await page.keyboard.press("c");
  await dialog.getByText("6 jobs will be cancelled").waitFor();
  await shoot(page, "jobs-bulk");
  await axeClean(page);
  // One of them is over before it is reached: the daemon's word is shown, and the others are done.
  await page.route(`**/v1/jobs/${ids[2]}`, (route) =>
    route.request().method() === "DELETE"
      ? route.fulfill({ status: 409, contentType: "application/problem+json", body: JSON.stringify({ type: "about:blank", title: "Conflict", status: 409, detail: "it is not to be cancelled now" }) })
      : route.continue(),
  );
  await dialog.getByRole("button", { name: "Cancel 6 jobs" }).click();
  await dialog.getByText("it is not to be cancelled now").waitFor();
  await dialog.getByText(/6 of 6 jobs asked for, 1 refused/).waitFor();
  await page.unroute(`**/v1/jobs/${ids[2]}`);
  await dialog.getByRole("button", { name: "Close" }).last().click();
  await page.waitForFunction(() => document.querySelectorAll(".state.cancelled").length === 5);
  await grid.focus();
  await page.keyboard.press("c");
  await dialog.getByText(/1 job will be cancelled\. 5 jobs are left as they are/).waitFor();
  await dialog.getByRole("button", { name: "Cancel 1 job" }).click();
  await page.waitForFunction(() => document.querySelectorAll(".state.cancelled").length === 6);
  await page.getByRole("button", { name: "Remove" }).click();
  await dialog.getByText("That cannot be undone").waitFor();
  await dialog.getByRole("button", { name: "Remove 6 jobs" }).click();
  await page.getByText("No job matches.").waitFor();
  assert.equal((await daemon.get("/v1/jobs?view=summary&label=bulk%3Dyes&limit=1")).total, 0);
});

test("fits a telephone", async () => {
  await page.setViewportSize({ width: 390, height: 844 });
  await go("/jobs");
  assert.ok((await page.evaluate(() => document.documentElement.scrollWidth)) <= 390, "the page scrolls sideways");
  await shoot(page, "jobs-narrow");
  await axeClean(page);
  await page.setViewportSize({ width: 1440, height: 900 });
});

test("says when the daemon is gone, and keeps what it showed", async () => {
  await go("/jobs");
  expectNoComplaints(page);
  await daemon.stop();
  await page.getByText("The daemon does not answer. What is shown is as it was").waitFor();
  assert.ok((await shownIds()).length > 10);
  await shoot(page, "jobs-lost");
});
