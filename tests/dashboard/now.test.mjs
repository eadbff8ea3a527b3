// The start page: what a newcomer sees first, and what the daemon does now, kept by one event stream.

import assert from "node:assert/strict";
import { mkdtempSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";

import { CountingProxy } from "./counting_proxy.mjs";
import { after, afterEach, axeClean, expectNoComplaints, fitsItsWidth, openPage, shoot, smallJob, startDaemon, test, until } from "./support.mjs";

const data = mkdtempSync(join(tmpdir(), "photond-now-"));
after(() => rmSync(data, { recursive: true, force: true }));
let daemon = await startDaemon({ data });

afterEach(() => daemon.idle());

const longJob = (more = {}) => smallJob({ stop: { seconds: 600 }, ...more });
const card = (page, id) => page.locator(".now-card", { hasText: id });
const queueIds = (page) => page.locator(".now-queue-row a:first-child").allInnerTexts();
const waitForQueue = (page, ids) =>
  page.waitForFunction((wanted) => [...document.querySelectorAll(".now-queue-what > a")].map((link) => link.textContent).join() === wanted, ids.join());

/** Waits until the page has asked for `count` pictures and for nothing else meanwhile: how many, and in which time of its own. */
async function picturesAlone(page, proxy, count) {
  const isPicture = (line) => line.includes("/preview.png");
  const clock = () => page.evaluate(() => performance.now() / 1000);
  for (let tries = 0; tries < 5; ++tries) {
    const since = await clock();
    const first = proxy.asked.length;
    const asked = () => proxy.asked.slice(first);
    await until(() => assert.ok(asked().length >= count, `asked for ${asked().join()}`));
    if (asked().every(isPicture)) return { asked: asked().length, seconds: (await clock()) - since };
  }
  assert.fail(`the page goes on asking for other things: ${proxy.asked.slice(-5 * count).join("\n")}`);
}

test("who has rendered nothing yet is told what this is and where to begin", async () => {
  const page = await openPage(daemon);
  await page.getByRole("heading", { name: "Where to begin" }).waitFor();
  await page.getByText("photond renders scenes by many methods").waitFor();
  const steps = page.locator(".now-steps a");
  assert.deepEqual(
    (await steps.all()).length && (await Promise.all((await steps.all()).map((step) => step.getAttribute("href")))),
    ["/studies/new?scene=cornell-box&preset=paths-photons", "/render?scene=cornell-box-glass", "/scenes"],
  );
  // Its pictures come with the page, and nothing is drawn for them.
  await page.waitForFunction(() => [...document.querySelectorAll(".now-steps img")].filter((image) => image.complete && image.naturalWidth === 480 && new URL(image.src).pathname.startsWith("/assets/")).length === 2);
  assert.equal(await page.evaluate(() => performance.getEntriesByType("resource").filter(({ name }) => name.includes("thumbnail")).length), 0);
  await page.getByText("reads scenes, makes pictures, measures errors").waitFor();
  await shoot(page, "now-empty", { fullPage: true });
  await axeClean(page);
  await page.setViewportSize({ width: 390, height: 844 });
  await fitsItsWidth(page);
  await shoot(page, "now-empty-narrow", { fullPage: true });
  await steps.nth(2).click();
  await page.getByRole("heading", { level: 1, name: "Scenes" }).waitFor();
});

test("running jobs, the queue and what has ended are shown as they change, without being asked for", async () => {
  const done = await daemon.run(smallJob());
  const running = await daemon.submit(longJob({ reference: `job:${done.id}` }));
  const proxy = await CountingProxy.before(daemon); // a worker asks for pictures, whose requests the page does not see
  const page = await openPage({ url: proxy.url });
  const shown = card(page, running.id);
  await shown.locator("img").waitFor();
  await shown.getByText("relative mse").waitFor();
  await shown.locator("canvas").waitFor();
  assert.equal(await page.locator(".now-first").count(), 0);
  await page.getByRole("navigation", { name: "What to do" }).waitFor();
  const passes = async () => Number(/([\d,]+) pass(?:es)? in/.exec(await shown.innerText())[1].replaceAll(",", ""));
  const before = await until(passes);
  const picture = await shown.locator("img").getAttribute("src");
  await page.waitForFunction((src) => ![null, undefined, src].includes(document.querySelector(".now-card img")?.getAttribute("src")), picture);
  await until(async () => assert.ok((await passes()) > before, "the passes stay as they were")); // told by another event than the picture
  await page.locator(".now-worker", { hasText: "rendering" }).getByRole("link", { name: running.id }).waitFor();
  await until(async () => assert.match(await page.locator(".now-worker meter").first().getAttribute("aria-label"), /of its limit/));
  await page.locator(".now-chart", { hasText: /Passes\s+[1-9]/ }).waitFor();
  await page.locator(".now-recent-job", { hasText: done.id }).locator("img").waitFor();

  // Sent by somebody else: they come by themselves, and in the order in which they will run.
  const first = await daemon.submit(longJob());
  const second = await daemon.submit(longJob({ reference: { method: { name: "path_tracing" }, stop: { passes: 3 } } }));
  const references = second.reference_jobs;
  await page.locator(".now-queue-row", { hasText: second.id }).getByText("waits for its reference").waitFor();
  await waitForQueue(page, [first.id, ...references, second.id]);
  await shoot(page, "now-busy", { fullPage: true });
  await axeClean(page);
  const later = await daemon.submit(longJob());
  await waitForQueue(page, [first.id, ...references, second.id, later.id]);
  await page.getByRole("button", { name: `${later.id} sooner` }).click();
  await waitForQueue(page, [later.id, first.id, ...references, second.id]);
  assert.equal((await daemon.get(`/v1/jobs/${later.id}`)).request.priority, 10);

  // While nothing begins or ends, the page asks for pictures alone, once what the change of priority made necessary is done.
  const { seconds, asked } = await picturesAlone(page, proxy, 3);
  // One each 2 s, by the page's clock; the first may have been under way already, and one may come at either end.
  assert.ok(asked <= seconds / 2 + 2, `${asked} pictures in ${seconds} s`);

  await page.getByRole("button", { name: `Cancel ${running.id}` }).click();
  await card(page, later.id).waitFor();
  await page.locator(".now-recent-job", { hasText: running.id }).getByText("cancelled").waitFor();
  await waitForQueue(page, [first.id, ...references, second.id]);
  for (const id of [second.id, ...references, first.id, later.id]) await daemon.cancel(id);
  await page.getByText("Nothing is rendered at the moment.").waitFor();
  await page.getByText("Nothing waits.").waitFor();
  await until(async () => assert.deepEqual(await queueIds(page), []));
  await page.setViewportSize({ width: 390, height: 844 });
  await fitsItsWidth(page);
  await shoot(page, "now-narrow", { fullPage: true });
  expectNoComplaints(page);
});

test("a daemon that is gone is said to be, and the page goes on by itself when it is back", async () => {
  const job = await daemon.submit(longJob());
  const page = await openPage(daemon, "/", { expected: /ERR_CONNECTION|ERR_INCOMPLETE|ERR_EMPTY|ERR_SOCKET|ERR_NETWORK/ });
  await card(page, job.id).locator("img").waitFor();
  await daemon.stop("SIGKILL");
  await page.getByText("The daemon does not answer. What is shown is the last it said").waitFor();
  await card(page, job.id).waitFor();
  await axeClean(page);
  writeFileSync(join(data, "films", "left_behind.film"), "of a store that is not this one");
  daemon = await startDaemon({ data, listen: new URL(daemon.url).host });
  await page.getByText("What is shown is the last it said").waitFor({ state: "detached" });
  await card(page, job.id).waitFor();
  await daemon.running(job.id); // again, so that what is submitted next waits for it
  await page.getByText("Files in the data folder's quarantine: 1.").waitFor();
  await axeClean(page);
  await shoot(page, "now-quarantine");
  const ended = await daemon.submit(smallJob({ priority: 10 }));
  await page.locator(".now-queue-row", { hasText: ended.id }).waitFor();
  await daemon.cancel(job.id);
  await page.locator(".now-recent-job", { hasText: ended.id }).getByText("succeeded").waitFor();
  expectNoComplaints(page);
});
