// One comparison on its page: live while it runs, then the verdict, figures, tables and what is saved of them.

import assert from "node:assert/strict";
import { readFile } from "node:fs/promises";

import { afterEach, axeClean, expectNoComplaints, fitsItsWidth, openPage, shoot, startDaemon, test, until } from "./support.mjs";

const daemon = await startDaemon();
const request = (more = {}) => ({
  scene: "cornell-box",
  image: { width: 48, height: 48 },
  reference: { method: { name: "path_tracing" }, stop: { passes: 256 } },
  entries: [
    { label: "paths", method: { name: "path_tracing" } },
    { label: "photons & rays", method: { name: "photon_mapping", parameters: { gather: "direct" } }, sweep: { photons: [500, 2000] } },
  ],
  stop: { seconds: 0.8 },
  metrics: ["relative_mse", "rmse"],
  seeds: [1, 2],
  ...more,
});
const compare = (more) => daemon.json("POST", "/v1/comparisons", request(more));
const page = await openPage(daemon, "/studies");
let study;
afterEach(() => page.unrouteAll({ behavior: "ignoreErrors" }));

const saved = async (press) => {
  const [file] = await Promise.all([page.waitForEvent("download"), press()]);
  return readFile(await file.path(), "utf8");
};
const section = (name) => page.locator("section").filter({ has: page.getByRole("heading", { name, exact: true, level: 2 }) });
const curves = () => page.locator(".study-plot-holder").first().locator("path");
/** A figure is drawn a moment after what it is drawn of. */
const seen = (what, wanted) => until(async () => assert.equal(await what(), wanted));

/** The report once the bias of every row is in it, which is measured after the last job. */
const wholeReport = () =>
  until(async () => {
    const report = await daemon.get(`/v1/comparisons/${study.id}/report.json`);
    assert.ok(report.table.every((row) => row.bias?.relative_mse), "a bias is not measured");
    return report;
  });

test("the list is empty, then follows what runs", async () => {
  await page.getByText("Nothing has been compared yet.").waitFor();
  await axeClean(page);
  study = await compare();
  await page.getByRole("link", { name: "paths, photons & rays" }).click();
  await page.waitForURL(`**/studies/${study.id}`);
});

test("a study is followed to its verdict without a reload", async () => {
  await page.getByRole("status").filter({ hasText: "jobs done" }).waitFor();
  await daemon.succeeds(`/v1/comparisons/${study.id}`);
  await page.locator(".room-title + p .state.succeeded").waitFor();
  const report = await daemon.get(`/v1/comparisons/${study.id}/report.json`);
  const verdict = page.getByRole("region", { name: "Verdict" });
  const { text: headline } = report.headlines.find((one) => one.metric === "relative_mse");
  await verdict.getByRole("heading", { name: `${headline}.`, exact: true }).waitFor();
  const said = report.verdicts.filter((one) => one.metric === "relative_mse").map((one) => one.text.slice(1));
  await until(async () => {
    const text = await verdict.textContent();
    assert.ok(said.length > 0 && said.every((one) => text.includes(one)), `${text}\n${said.join("\n")}`);
  });
  for (const [name, images] of [["Pictures", 4], ["Bias and noise apart", 3]]) {
    await section(name).locator(".study-strip").scrollIntoViewIfNeeded();
    await seen(() => section(name).locator("img").count(), images);
  }
  await shoot(page, "study", { fullPage: true });
  await axeClean(page);
});

test("the tables say what the daemon says", async () => {
  const report = await daemon.get(`/v1/comparisons/${study.id}/report.json`);
  const table = section("Time to reach relative_mse");
  const levels = report.table[0].time_to_error.relative_mse;
  await seen(() => table.locator("thead th").count(), levels.length + 1);
  const reachable = levels.filter((_, i) => report.table.some((row) => row.time_to_error.relative_mse[i].seconds !== null)).length;
  assert.ok(reachable > 0);
  await until(async () => assert.ok((await table.locator("td.study-best").count()) >= reachable));
  const csv = await saved(() => table.getByRole("button", { name: "CSV" }).click());
  const lines = csv.trim().split("\r\n");
  assert.equal(lines.length, 1 + 3 * levels.length);
  const first = report.table[0].time_to_error.relative_mse[0];
  assert.ok(lines[1].startsWith(`paths,relative_mse,${first.error},${first.seconds ?? ""},`), lines[1]);
  assert.ok(csv.includes('"photons & rays, photons 500",'));
  await table.getByRole("button", { name: "LaTeX" }).click();
  const latex = await table.getByLabel("LaTeX table").textContent();
  for (const part of ["\\toprule", "\\bottomrule", "photons \\& rays, photons 500 &", "time to a relative\\_mse of", `\\begin{tabular}{l${"r".repeat(levels.length)}}`]) assert.ok(latex.includes(part), `${part}\n${latex}`);
});

test("bias stands apart from noise, with maps of where it is", async () => {
  const report = await wholeReport();
  const bias = section("Bias and noise apart");
  for (const row of report.table) await bias.getByRole("cell", { name: row.bias.relative_mse.text, exact: true }).first().waitFor();
  const map = await until(() => daemon.get(`/v1/comparisons/${study.id}/rows/1/bias.json?layer=indirect`));  // 503 while others are drawn
  await bias.getByRole("combobox", { name: "Layer" }).selectOption("indirect");
  await bias.getByRole("img", { name: "Where photons & rays, photons 500 is biased, indirect" }).waitFor();
  await bias.getByText(map.text, { exact: true }).first().waitFor();
});

test("what is not told apart from 0 is an upper bound, and what is not gone below a line", async () => {
  const report = await wholeReport();
  const { mean_curve, error, error_at_time, bias } = report.table[0];
  const unknown = (value) => Object.assign(value, { low: null, high: null, interval: [-0.006, 0.004] });
  Object.assign(unknown(mean_curve.relative_mse.at(-1)), { error: -0.001 });
  Object.assign(unknown(error.relative_mse), { value: -0.001, near_reference: true });
  Object.assign(unknown(error_at_time.relative_mse[0]), { error: -0.001 });
  Object.assign(bias.relative_mse, { squared_bias: 0.02, low: 0.01, high: 0.03, floor: true });
  report.table[1].mark = "the reference lacks some light: what this entry has of it counts as error";
  await page.route("**/report.json", (route) => route.fulfill({ json: report }));
  await page.reload();
  await page.getByText("paths: reaches no less than 0.01").waitFor();
  await page.getByText(`: ${report.table[1].mark}.`).waitFor();
  await seen(() => page.locator(".study-plot-holder").first().locator('path[d^="M-5 0"]').count(), 1);
  await page.getByText("Arrows: upper bounds").waitFor();
  const firstRow = (name, text) => until(async () => assert.match(await section(name).locator("tbody tr").first().innerText(), text));
  await firstRow("relative_mse after a time", /below 0\.004\s+\(-0\.006 to 0\.004\)/);
  await firstRow("What it cost", /below 0\.004\s+not told apart from 0/);
  await shoot(page, "study-bounds");
  await page.unroute("**/report.json");
  await page.reload();
  await page.locator(".study-plot-holder svg").first().waitFor();
});

test("entries are switched and the metric chosen in the address", async () => {
  await curves().first().waitFor({ state: "attached" });
  const before = await curves().count();
  await page.getByRole("button", { name: /^photons & rays, photons 500/ }).click();
  await page.waitForURL(/hide=1/);
  await seen(() => curves().count().then((count) => count < before), true);
  await page.getByRole("combobox", { name: "Error" }).selectOption("rmse");
  await page.waitForURL(/metric=rmse/);
  await page.reload();
  await section("Time to reach rmse").waitFor();
  await page.getByRole("button", { name: /^photons & rays, photons 500/, pressed: false }).click();
});

test("curves are read by keyboard", async () => {
  await page.locator(".study-plot-holder svg").first().waitFor();
  await page.getByLabel(/against time. Left and right arrows/).focus();
  await page.keyboard.press("ArrowRight");
  await page.locator(".study-readout b").waitFor();
  const first = await page.locator(".study-readout b").textContent();
  await page.keyboard.press("ArrowRight");
  await seen(() => page.locator(".study-readout b").textContent().then((text) => text !== first), true);
});

test("a figure is saved as an SVG that needs nothing else", async () => {
  const svg = await saved(() => page.getByRole("button", { name: "Save SVG" }).first().click());
  assert.match(svg, /^<\?xml/);
  for (const part of ['font-family="Liberation Sans', "photons &amp; rays, photons 2000", 'fill="#ffffff"', "<title>"]) assert.ok(svg.includes(part), part);
  for (const part of ["<style", "class=", "var(--", "currentColor\" stroke=\"currentColor"]) assert.ok(!svg.includes(part), part);
  const parsed = await page.evaluate((text) => new DOMParser().parseFromString(text, "image/svg+xml").querySelectorAll("parsererror").length, svg);
  assert.equal(parsed, 0);
});

test("pictures: maps of the error, and all entries at one time when asked for", async () => {
  const pictures = section("Pictures");
  await pictures.getByRole("button", { name: "FLIP" }).click();
  await page.waitForURL(/picture=flip/);
  await seen(() => pictures.locator("img").count(), 3);
  await pictures.getByText("what all are compared with").waitFor();
  await pictures.getByRole("button", { name: "Images" }).click();
  const equalTimes = pictures.getByRole("combobox", { name: "At" }).locator("optgroup[label='Equal time'] option");
  await equalTimes.first().waitFor({ state: "attached" });
  const times = await equalTimes.evaluateAll((options) => options.map((option) => option.value));
  await pictures.getByRole("combobox", { name: "At" }).selectOption(times[0]);
  await pictures.getByRole("button", { name: "Render 3 pictures" }).click();
  await seen(() => pictures.locator("img").count(), 4);
  const jobs = (await daemon.get("/v1/jobs?view=summary&label=entry")).items;
  assert.equal(jobs.length, 3);
  await page.reload();
  await section("Pictures").scrollIntoViewIfNeeded();
  await seen(() => section("Pictures").locator("img").count(), 4); // found again by their labels
  await seen(() => section("Pictures").getByRole("button", { name: /^Render/ }).count(), 0);
  const link = section("Pictures").getByRole("link", { name: "Compare them closely" });
  await seen(() => link.getAttribute("href").then((path) => path.split("job:").length - 1), 4);
});

test("nothing is wider than a phone", async () => {
  await page.setViewportSize({ width: 390, height: 844 });
  await fitsItsWidth(page);
  await shoot(page, "study-phone", { fullPage: true });
  await page.setViewportSize({ width: 1440, height: 900 });
});

test("what runs is cancelled, and a study that is not there is said to be none", async () => {
  const long = await compare({ stop: { seconds: 600 }, entries: [{ method: { name: "path_tracing" } }], seeds: [9] });
  await page.goto(`${daemon.url}/studies/${long.id}`);
  await page.getByRole("button", { name: "Cancel", exact: true }).click();
  await page.getByText("The comparison was cancelled").waitFor();
  expectNoComplaints(page);
  const lost = await openPage(daemon, "/studies/C999", { expected: /404/ });
  await lost.getByText("there is no comparison 'C999'").waitFor();
  await axeClean(lost);
});

test("it is given a title and notes, and the list says what it came to", async () => {
  await page.goto(`${daemon.url}/studies/${study.id}`);
  await page.getByRole("button", { name: "Give it a title and notes" }).click();
  const dialog = page.getByRole("dialog");
  await dialog.getByLabel("Title").fill("Which is sooner");
  await dialog.getByLabel("Notes").fill("First line\nand a second");
  await shoot(page, "study-remarks");
  await dialog.getByRole("button", { name: "Save" }).click();
  await page.getByRole("heading", { name: "Which is sooner", level: 1 }).waitFor();
  assert.equal(await page.locator(".study-notes").innerText(), "First line\nand a second");
  assert.deepEqual((({ title, notes }) => [title, notes])((await daemon.get(`/v1/comparisons/${study.id}`)).request), ["Which is sooner", "First line\nand a second"]);

  await page.goto(`${daemon.url}/studies`);
  const { headlines } = await daemon.get(`/v1/comparisons/${study.id}`);
  const row = page.getByRole("row").filter({ has: page.getByRole("link", { name: "Which is sooner" }) });
  await row.getByText(headlines.find((one) => one.metric === "relative_mse").text).waitFor();
  await axeClean(page);
  await shoot(page, "studies-titled");
  expectNoComplaints(page);
});
