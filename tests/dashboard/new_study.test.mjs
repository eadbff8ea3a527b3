// A new comparison: by one press, and with everything chosen.

import assert from "node:assert/strict";

import { axeClean, expectNoComplaints, fitsItsWidth, openPage, shoot, startDaemon, test, until } from "./support.mjs";

const daemon = await startDaemon();
// A job that ends before its first pass has no picture, and the page may ask for one before it hears of that.
const page = await openPage(daemon, "/", { expected: /status of 422|status of 404.*\/preview\.png/ });
const summary = page.getByRole("region", { name: "What it will take" });
const go = summary.getByRole("button", { name: "Compare", exact: true });
const json = async () => JSON.parse(await page.getByLabel("The request as JSON").textContent());
const sent = async () => {
  await go.click();
  await page.waitForURL(/\/studies\/C\d+$/);
  return daemon.get(`/v1/comparisons/${page.url().split("/").at(-1)}`);
};

test("from the start page a newcomer compares methods by pressing twice", async () => {
  await page.getByRole("banner").getByRole("link", { name: "Compare methods" }).click();
  await summary.getByText(/MB at most/).waitFor();
  await page.locator(".new-study-scene img").first().waitFor();
  await shoot(page, "new-study", { fullPage: true });
  await axeClean(page);
  const comparison = await sent();
  assert.equal(comparison.request.scene, "cornell-box");
  assert.deepEqual(comparison.request.entries.map((entry) => entry.method.name), ["path_tracing", "photon_mapping", "photon_splatting"]);
  assert.equal(comparison.request.stop.seconds, 10);
  await daemon.json("DELETE", `/v1/comparisons/${comparison.id}`);
});

test("entries, a sweep, budget and seeds are chosen; the estimate follows", async () => {
  await page.goto(`${daemon.url}/studies/new?scene=keyhole&preset=paths-photons`);
  await summary.getByText(/MB at most/).waitFor();
  await page.getByRole("button", { name: "128 × 128" }).click();
  await page.getByLabel("Width").fill("32");
  await page.getByLabel("Height").fill("24");
  const photons = page.locator(".new-study-entry").nth(1);
  await photons.locator("summary").first().click();
  await photons.getByRole("button", { name: "Sweep a parameter" }).click();
  await photons.getByLabel("Values").fill("100, 200");
  await page.getByRole("spinbutton", { name: "Time" }).fill("0.2");
  await page.getByLabel("Seeds").fill("3, 4");
  await page.getByRole("region", { name: "Reference" }).getByLabel("Passes").fill("16");
  await summary.locator("dt:text-is('Jobs') + dd:text-is('6')").waitFor();
  await summary.getByText("As JSON").click();
  await until(async () => {
    const request = await json();
    assert.equal(request.scene, "keyhole");
    assert.deepEqual(request.image, { width: 32, height: 24 });
    assert.deepEqual(request.entries[1].sweep, { photons: [100, 200] });
    assert.deepEqual(request.seeds, [3, 4]);
  });
});

test("faults are said at their fields, and nothing is sent", async () => {
  const photons = page.locator(".new-study-entry").nth(1);
  await photons.getByLabel("Values").fill("100, 0");
  await photons.locator(".fault").getByText(/outside/).waitFor();
  await summary.locator("code").getByText("/entries/1/sweep/photons/1").waitFor();
  await until(async () => assert.ok(await go.isDisabled()));
  await axeClean(page);
  await photons.getByLabel("Values").fill("100, 200");
  await page.getByLabel("Width").fill("0");
  await page.getByRole("region", { name: "Scene" }).locator(".fault").first().waitFor();
  await page.getByLabel("Width").fill("32");
  await summary.getByText(/MB at most/).waitFor();
});

test("a reload loses nothing, and the comparison can be had again and changed", async () => {
  await page.reload();
  await summary.getByText(/MB at most/).waitFor();
  await summary.getByText("As JSON").click();
  await until(async () => assert.deepEqual((await json()).seeds, [3, 4]));
  const comparison = await sent();
  assert.equal(comparison.jobs.length, 6);
  await page.getByRole("link", { name: "Repeat or change it" }).click();
  await page.waitForURL(/from=C\d+/);
  await summary.locator("dt:text-is('Jobs') + dd:text-is('6')").waitFor();
  await page.getByLabel("Seeds").fill("5");
  await summary.locator("dt:text-is('Jobs') + dd:text-is('3')").waitFor();
  const again = await sent();
  assert.notEqual(again.id, comparison.id);
  assert.deepEqual({ ...again.request, seeds: null }, { ...comparison.request, seeds: null });
});

test("nothing is wider than a phone, and the browser has nothing to complain of", async () => {
  await page.goto(`${daemon.url}/studies/new`);
  await page.setViewportSize({ width: 390, height: 844 });
  await summary.getByText(/MB at most/).waitFor();
  await fitsItsWidth(page);
  await shoot(page, "new-study-phone");
  expectNoComplaints(page);
});
