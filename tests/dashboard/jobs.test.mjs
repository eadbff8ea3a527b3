// The Jobs page over a long history: found, read, steered, one job or all at once.
// PHOTOND_MANY_JOBS=100000 measures it over the history that the page is made for.

import assert from "node:assert/strict";

import { historyOf } from "./history.mjs";
import { afterEach, axeClean, expectNoComplaints, fitsItsWidth, openPage, shoot, smallJob, startDaemon, test, until } from "./support.mjs";

const kJobs = Number(process.env.PHOTOND_MANY_JOBS ?? 4000);
const daemon = await startDaemon({ data: historyOf(kJobs) });
// Made-up jobs have no films, so there is no picture of them where one is opened or compared for long enough.
const page = await openPage(daemon, "/jobs", { expected: /ERR_CONNECTION_REFUSED|ERR_INCOMPLETE_CHUNKED|ERR_EMPTY_RESPONSE|ERR_CONNECTION_RESET|status of 409|status of 404.*\/(preview\.png|pixels\?)/ });

afterEach(async () => {
  await page.unrouteAll({ behavior: "ignoreErrors" });
  await daemon.idle();
});

const grid = page.getByRole("grid");
const rowOf = (id) => grid.getByRole("row").filter({ has: page.getByRole("link", { name: id, exact: true }) });
const matching = (count) => page.waitForFunction((wanted) => document.querySelector("[role=grid]").getAttribute("aria-rowcount") === String(wanted + 1), count);
/** The rows of the place scrolled to are there, all of those in view, and none waits for its job. */
const loaded = () =>
  page.waitForFunction(() => {
    const rows = [...document.querySelectorAll(".jobs-space .jobs-row")];
    if (rows.length === 0 || document.querySelector(".jobs-row.waits")) return false;
    const view = document.querySelector("[role=grid]");
    const { top, bottom } = view.getBoundingClientRect();
    const isAt = (row, index) => row.getAttribute("aria-rowindex") === String(index);
    const reachesUp = isAt(rows[0], 2) || rows[0].getBoundingClientRect().top <= top;
    const reachesDown = isAt(rows.at(-1), view.getAttribute("aria-rowcount")) || rows.at(-1).getBoundingClientRect().bottom >= bottom;
    return reachesUp && reachesDown;
  });
/** Requests that the page has made of the daemon since it was opened. */
const requests = () => page.evaluate(() => performance.getEntriesByType("resource").filter(({ name }) => new URL(name).pathname.startsWith("/v1/")).map(({ name }) => name));
const shownIds = () => page.$$eval(".jobs-space .jobs-row .jobs-job a", (links) => links.map((link) => link.textContent));
/** The active row is drawn a frame after the key that made it active. */
const becomesActive = (id) => page.waitForFunction((wanted) => document.getElementById(document.querySelector("[role=grid]").getAttribute("aria-activedescendant"))?.querySelector("a")?.textContent === wanted, id);
async function go(path) {
  await page.goto(daemon.url + path);
  await loaded();
}

test("is usable over a long history after a few requests for a few rows", async () => {
  await loaded();
  const times = [];
  for (let i = 0; i < 3; ++i) {
    await page.goto(`${daemon.url}/jobs`);
    await loaded();
    times.push(await page.evaluate(() => performance.now()));
  }
  const made = await requests();
  console.log(`# ${kJobs} jobs: usable after ${times.map((time) => time.toFixed(0)).join(", ")} ms and ${made.length} requests`);
  await matching(kJobs);
  assert.ok(made.length < 12, made.join("\n"));
  await becomesActive(`J${kJobs}`);
});

test("scrolls by fetching what is looked at, and draws little meanwhile", async () => {
  const frames = await page.evaluate(async () => {
    const grid = document.querySelector("[role=grid]");
    let drawn = 0;
    const watcher = new MutationObserver((changes) => {
      for (const { addedNodes } of changes) drawn += [...addedNodes].filter((node) => node.classList?.contains("jobs-row")).length;
    });
    watcher.observe(document.querySelector(".jobs-space"), { childList: true });
    const frame = () => new Promise((done) => requestAnimationFrame(done));
    const measure = async (steps, move) => {
      const times = [];
      performance.clearResourceTimings();
      drawn = 0;
      let last = performance.now();
      for (let i = 0; i < steps; ++i) {
        move(i / steps);
        await frame();
        times.push(performance.now() - last);
        last = performance.now();
      }
      times.sort((a, b) => a - b);
      const rows = document.querySelectorAll(".jobs-space .jobs-row").length;
      return { median: times[times.length >> 1], p95: times[Math.floor(times.length * 0.95)], rows, drawn, requests: performance.getEntriesByType("resource").length };
    };
    const wheel = await measure(90, () => (grid.scrollTop += 240));
    const drag = await measure(90, (share) => (grid.scrollTop = share * (grid.scrollHeight - grid.clientHeight)));
    return { wheel, drag };
  });
  const said = ({ median, p95, drawn, requests }) => `${median.toFixed(1)} ms a frame, p95 ${p95.toFixed(1)}, ${drawn} rows drawn, ${requests} requests`;
  console.log(`# wheel: ${said(frames.wheel)}; scrollbar: ${said(frames.drag)}`);
  for (const { rows } of [frames.wheel, frames.drag]) assert.ok(rows < 80, "only rows in view are there");
  // The wheel passes 600 rows, each drawn once and in one answer; the scrollbar's every place is another view of 35.
  assert.ok(frames.wheel.drawn <= 640, `the wheel draws ${frames.wheel.drawn} rows`);
  assert.ok(frames.wheel.requests <= 12, `the wheel makes ${frames.wheel.requests} requests`);
  assert.ok(frames.drag.drawn <= 90 * 40, `the scrollbar draws ${frames.drag.drawn} rows`);
  assert.ok(frames.drag.requests <= 90, `the scrollbar makes ${frames.drag.requests} requests`);
  await grid.press("End");
  await loaded();
  await becomesActive("J1");
  const last = rowOf("J1");
  await until(async () => assert.equal(await last.getAttribute("aria-rowindex"), String(kJobs + 1)));
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
  await until(async () => assert.equal(await grid.locator("[aria-selected=true]").count(), 2));
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
  const before = await shownIds();
  const chosen = grid.locator(".jobs-space .jobs-row").nth(12);
  const id = await chosen.locator(".jobs-job a").textContent();
  await chosen.locator(".jobs-scene").click();
  await becomesActive(id);
  await grid.focus();
  await page.keyboard.press("Enter");
  await page.waitForURL(`**/jobs/${id}`);
  await page.goBack();
  await loaded();
  await page.waitForFunction((wanted) => document.querySelector(`.jobs-job a[href="/jobs/${wanted}"]`), id);
  await until(async () => assert.deepEqual((await shownIds()).slice(10, 20), before.slice(10, 20)));
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
  await until(async () => assert.equal(await grid.locator(".state:not(.failed)").count(), 0));
  await shoot(page, "jobs-failed");
  await page.keyboard.type("method:path_tracing ");
  const both = (await daemon.get("/v1/jobs?view=summary&state=failed&method=path_tracing&limit=1")).total;
  await matching(both);
  assert.ok(both < failed);
  // The chips count what matches the other words.
  await page.getByRole("button", { name: /^failed/, pressed: true }).waitFor();
  await go("/jobs?method=path_tracing&state=failed");
  await matching(both);
  await until(async () => assert.equal(await page.locator("#jobs-filter").inputValue(), "state:failed method:path_tracing"));
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
  const placeOf = (id) => page.evaluate((wanted) => document.querySelector(`.jobs-job a[href="/jobs/${wanted}"]`)?.getBoundingClientRect().top, id);
  const read = (await shownIds())[15];
  const before = await placeOf(read);
  const job = await daemon.run(smallJob());
  await page.getByRole("button", { name: /1 new job/ }).click({ trial: true });
  assert.ok(Math.abs((await placeOf(read)) - before) < 1, "the row that was read has moved");
  await page.getByRole("button", { name: /1 new job/ }).click();
  await rowOf(job.id).getByText("succeeded").waitFor();
  await matching(kJobs + 1);
  // And a job that is watched changes where it stands.
  const long = await daemon.submit(smallJob({ image: { width: 128, height: 128 }, stop: { seconds: 600 } }));
  await rowOf(long.id).getByText("running").waitFor();
  await grid.focus();
  await page.keyboard.press("Home");
  await becomesActive(long.id);
  await page.keyboard.press("c");
  await rowOf(long.id).getByText("cancelled").waitFor();
});

test("many jobs are cancelled, given another priority, retried and removed, and what fails is said", async () => {
  const labels = { bulk: "yes" };
  const ids = [];
  for (let i = 0; i < 6; ++i) ids.push((await daemon.submit(smallJob({ image: { width: 128, height: 128 }, stop: { seconds: 600 }, labels }))).id);
  await go("/jobs?label=bulk%3Dyes");
  await matching(6);
  // One by its key.
  await grid.focus();
  await becomesActive(ids[5]);
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
  await until(async () => assert.equal((await daemon.get("/v1/jobs?view=summary&label=bulk%3Dyes&limit=1")).total, 0));
});

test("fits a telephone", async () => {
  await page.setViewportSize({ width: 390, height: 844 });
  await go("/jobs");
  await fitsItsWidth(page);
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
