// Ten tabs of one browser: it opens six connections to a host, and all of them live by one stream of events and ask for few
// pictures at once, so that a button is never behind them.
import assert from "node:assert/strict";

import { CountingProxy } from "./counting_proxy.mjs";
import { expectNoComplaints, openPage, smallJob, startDaemon, test, until } from "./support.mjs";

const kPictures = /\.png/, kStreams = /\/v1\/events/;
/** Whose passes take a while, so that its previews wait for them. */
const slowJob = (more = {}) => smallJob({ image: { width: 640, height: 640 }, stop: { passes: 100_000 }, ...more });

const daemon = await startDaemon();

/** Ten tabs of one browser, the last one of the job. */
async function tenTabs(url, job) {
  const rooms = ["/", `/jobs/${job}`, "/scenes", "/jobs", "/scenes/cornell-box", "/studies", `/jobs/${job}`, "/", "/sequences", `/jobs/${job}`];
  const first = await openPage({ url }, rooms[0]);
  const tabs = [first];
  for (const room of rooms.slice(1)) {
    const tab = await first.context().newPage();
    await tab.goto(url + room);
    tabs.push(tab);
  }
  return tabs;
}

/** Presses Cancel: when that was, and the daemon's answer. */
async function cancelIn(tab) {
  await tab.evaluate(() => document.addEventListener("click", () => (window.clickedAt = Date.now()), { capture: true, once: true }));
  const answer = tab.waitForResponse((response) => response.request().method() === "DELETE");
  await tab.getByRole("button", { name: "Cancel" }).click();
  return { answered: await answer, clicked: await tab.evaluate(() => window.clickedAt) };
}

test("ten tabs live by one stream, and Cancel waits for no picture", async () => {
  const proxy = await CountingProxy.before(daemon);
  const { id } = await daemon.submit(slowJob());
  await daemon.running(id, 1);
  proxy.hold();
  const tabs = await tenTabs(proxy.url, id);
  for (const tab of tabs) await tab.getByText("1 running, 0 waiting").waitFor();
  assert.equal(proxy.openOf(kStreams).length, 1, "one stream of events for all tabs");
  assert.equal(proxy.asked.filter((line) => kStreams.test(line)).length, 1);
  await until(() => assert.equal(proxy.openOf(kPictures).length, 2));
  assert.equal(proxy.mostPictures, 2, "never more than two at once");

  const last = tabs.at(-1);
  const { clicked, answered } = await cancelIn(last);
  assert.equal(answered.status(), 202);
  assert.ok(proxy.openOf(kPictures).length > 0, "pictures wait still");
  console.log(`Cancel reached the daemon ${proxy.cameAt("DELETE") - clicked} ms after the click, ten tabs open and pictures held`);
  await last.getByRole("button", { name: "Cancelling …" }).or(last.getByRole("button", { name: "Retry" })).waitFor();

  // The tab that was first is closed: the others hear of it all the same.
  await tabs[0].close();
  assert.equal((await daemon.finished(id)).state, "cancelled");
  for (const tab of tabs.slice(1)) await tab.getByText("0 running, 0 waiting").waitFor();
  for (const tab of [tabs[1], tabs[6], last]) await tab.getByRole("button", { name: "Retry" }).waitFor();
  assert.equal(proxy.asked.filter((line) => kStreams.test(line)).length, 1, "by the same stream");

  proxy.release();
  await tabs[1].getByRole("img").first().waitFor();
  expectNoComplaints(tabs[0]);
  for (const tab of tabs.slice(1)) await tab.close();
  await until(() => assert.equal(proxy.openOf(kStreams).length, 0, "the stream ends with the last tab"));
});

test("Cancel reaches the daemon at once while it renders a slow pass", async () => {
  const { id } = await daemon.submit(slowJob({ image: { width: 1536, height: 1536 } }));
  await daemon.running(id, 1);
  const tabs = await tenTabs(daemon.url, id);
  for (const tab of tabs) await tab.getByText("1 running, 0 waiting").waitFor();
  assert.match(await (await fetch(`${daemon.url}/metrics`)).text(), /^photond_event_clients 1$/m);
  const last = tabs.at(-1);
  const { clicked, answered } = await cancelIn(last);
  assert.equal(answered.status(), 202);
  console.log(`Cancel was answered ${Math.round(answered.request().timing().startTime + answered.request().timing().responseStart - clicked)} ms after the click, ten tabs open`);
  await last.getByRole("button", { name: "Retry" }).waitFor();
  await daemon.finished(id);
});

test("a browser without workers that tabs share does the same for each tab", async () => {
  const proxy = await CountingProxy.before(daemon);
  const { id } = await daemon.submit(slowJob());
  await daemon.running(id);
  const page = await openPage({ url: proxy.url }, "/studies");
  await page.context().addInitScript(() => delete window.SharedWorker);
  await page.goto(`${proxy.url}/jobs/${id}`);
  await page.getByRole("button", { name: "Cancel" }).click();
  await page.getByRole("button", { name: "Retry" }).waitFor();
  await until(() => assert.equal(proxy.openOf(kStreams).length, 1));
  expectNoComplaints(page);
});
