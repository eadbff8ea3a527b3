// One job, while it runs and afterwards.

import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { readFileSync } from "node:fs";
import { dirname, resolve } from "node:path";
import { fileURLToPath } from "node:url";

import { historyOf } from "./history.mjs";
import { CountingProxy } from "./counting_proxy.mjs";
import { afterEach, axeClean, expectNoComplaints, fitsItsWidth, openPage, shoot, smallJob, startDaemon, test, until } from "./support.mjs";

const repository = resolve(dirname(fileURLToPath(import.meta.url)), "../..");
// Old jobs among which some have failed.
const daemon = await startDaemon({ data: historyOf(60) });
const measured = await daemon.run(
  smallJob({
    method: { name: "photon_mapping", parameters: { photons: 2000, gather: "direct", keep_photon_map: true, indirect_bounces: 5 } },
    stop: { passes: 6, target: { metric: "relative_mse", value: 1e-9 } },
    reference: { method: { name: "path_tracing" }, stop: { passes: 8 } },
    layers: ["albedo", "depth", "caustic"],
    labels: { study: "it's one" },
  }),
);
const page = await openPage(daemon, `/jobs/${measured.id}`);
afterEach(async () => {
  await page.unrouteAll({ behavior: "ignoreErrors" });
  await daemon.idle();
});

const panel = (title) => page.getByRole("region", { name: title, exact: true });

test("shows what became of it and what it took", async () => {
  await panel("Image").locator(".picture-frame > img").first().waitFor();
  await panel("Error").locator("canvas").waitFor();
  await panel("Facts").getByText("photon mapping").waitFor();
  await panel("Facts").getByText("6 passes or relative_mse ≤ 1e-9").waitFor();
  await panel("Facts").getByText("light of more than 5 bounces").waitFor();
  const life = panel("State over time").getByRole("row");
  await until(async () => assert.match(await life.last().innerText(), /attempt 1.*cpu.*6.*succeeded/s));
  const stages = panel("Time by stage");
  for (const { name } of measured.statistics.stages) await stages.getByRole("cell", { name: name.replaceAll("_", " "), exact: true }).waitFor();
  const memory = panel("Memory");
  for (const [name, bytes] of Object.entries(measured.statistics.memory.structures))
    if (bytes > 0) await memory.getByRole("cell", { name: name.replaceAll("_", " "), exact: true }).waitFor();
  await panel("Counts and rates").getByText("photons stored").waitFor();
  await panel("Log").getByText("attempt 1 succeeded after 6 passes").waitFor();
  await shoot(page, "job", { fullPage: true });
  await axeClean(page);
});

test("shows the layer, the exposure and the error that the address says", async () => {
  const image = panel("Image");
  await image.getByRole("button", { name: "caustic" }).click();
  await page.waitForURL(/layer=caustic/);
  await image.getByRole("button", { name: "FLIP" }).click();
  await page.waitForURL(/show=flip/);
  await image.getByRole("img", { name: /^flip of/ }).waitFor();
  const proxy = await CountingProxy.before(daemon); // pictures are asked for by a worker, whose requests the page does not see
  await page.goto(`${proxy.url}/jobs/${measured.id}?layer=indirect&exposure=2&curve=filmic`);
  await until(() => assert.ok(proxy.asked.some((line) => ["preview.png", "exposure=2", "layer=indirect"].every((part) => line.includes(part)))));
  await image.getByRole("button", { name: "indirect", pressed: true }).waitFor();
  // Layers without a picture lead to where their numbers are.
  assert.match(await image.getByRole("link", { name: "depth" }).getAttribute("href"), /\/compare\?images=job:J\d+&layer=depth/);
  assert.match(decodeURIComponent(await image.getByRole("link", { name: /Look closer/ }).getAttribute("href")), new RegExp(`images=job:${measured.id},job:${measured.reference_job}&reference=job:${measured.reference_job}&layer=indirect`));
});

test("the curve is of any metric that was measured", async () => {
  await page.goto(`${daemon.url}/jobs/${measured.id}`);
  const error = panel("Error");
  await error.getByRole("button", { name: "relative mse", exact: true, pressed: true }).waitFor();
  await error.getByRole("button", { name: "smape" }).click();
  await error.getByRole("img", { name: /smape/ }).waitFor();
  await error.locator(".u-legend", { hasText: /relative mse[\s\S]*smape[\s\S]*target/ }).waitFor(); // the chart is made anew, a moment later
  await error.locator(".job-against select").selectOption("passes");
  await error.getByRole("img", { name: /against passes/ }).waitFor();
});

test("errors stand with what their reference leaves open", async () => {
  const known = structuredClone(measured);
  for (const point of known.curve) point.intervals = { relative_mse: [-0.006, 0.004] };
  known.curve.at(-1).metrics.relative_mse = -0.001;
  known.error_now = { metric: "relative_mse", value: -0.001, interval: [-0.006, 0.004] };
  Object.assign(known.statistics.error, { relative_mse: 0.0012, rmse: null });
  known.statistics.error_interval = { relative_mse: [0.0008, 0.0016], rmse: [0, 0.02] };
  await page.route(`**/v1/jobs/${measured.id}`, (route) => route.fulfill({ json: known }));
  await page.reload();
  await panel("Facts").getByText("below 0.004 (not told apart from 0)").waitFor();
  for (const id of measured.reference_jobs) await panel("Facts").getByRole("link", { name: id, exact: true }).waitFor();
  const error = panel("Error");
  await error.getByRole("img", { name: "relative mse below 0.004 (not told apart from 0)" }).waitFor();
  await error.locator(".u-legend", { hasText: "relative mse, upper bound" }).waitFor();
  await error.getByText("Measured against two films of different seeds").waitFor();
  await error.getByText("All that was measured at the end").click();
  await error.getByRole("cell", { name: "0.0012 (0.0008 to 0.0016)" }).waitFor();
  await error.getByRole("cell", { name: "below 0.02 (not told apart from 0)" }).waitFor();
  await shoot(page, "job-intervals");
  expectNoComplaints(page);
  await page.unroute(`**/v1/jobs/${measured.id}`);
});

test("the curve's axis ends, whatever moment it begins at", async () => {
  const shown = panel("Error").locator("canvas");
  // Where uPlot steps from a moment itself, these make an axis without an end.
  for (const first of [0.0096, 0.000097, 0.96]) {
    const curve = [1, 2.5, 40].map((times, index) => ({ ...measured.curve[index], seconds: first * times }));
    await page.route(`**/v1/jobs/${measured.id}`, (route) => route.fulfill({ json: { ...measured, curve } }));
    await page.reload();
    await shown.waitFor();
    expectNoComplaints(page);
    await page.unroute(`**/v1/jobs/${measured.id}`);
  }
});

test("the request says what was asked for, and the rest when asked", async () => {
  const request = panel("Request");
  await page.goto(`${daemon.url}/jobs/${measured.id}`);
  await until(async () => assert.equal(await request.getByText("gather", { exact: true }).count(), 1));
  // Which settings are as by default the page knows once it has the methods.
  await until(async () => assert.equal(await request.getByText("gather rays").count(), 0));
  await request.getByRole("button", { name: /Show the \d+ settings that are as by default/ }).click();
  await request.getByText("gather rays").waitFor();
  await until(async () => assert.ok((await request.getByText("asked for", { exact: true }).count()) > 5));
});

test("its curl and Python lines give the same job", async () => {
  const repeat = panel("Repeat it");
  const curl = await repeat.locator("pre").innerText();
  const answer = JSON.parse(execFileSync("/bin/sh", ["-c", curl], { stdio: ["ignore", "pipe", "ignore"] }).toString());
  const again = await daemon.finished(answer.id);
  assert.equal(again.statistics.pixel_hash, measured.statistics.pixel_hash);
  assert.deepEqual(again.request, measured.request);
  await repeat.getByRole("button", { name: "Copy" }).click();
  await page.getByText("curl copied.").waitFor();
  assert.equal(await page.evaluate(() => navigator.clipboard.readText()), curl);
  await repeat.getByRole("button", { name: "Python" }).click();
  // Without numpy there is no array to look at; the job is the same.
  await repeat.getByLabel("Python to repeat the job").waitFor();
  const python = (await repeat.locator("pre").innerText()).replace(/^image = .*$/m, "print(job.id)");
  const id = execFileSync("python3", ["-c", python], { env: { ...process.env, PYTHONPATH: resolve(repository, "clients/python") } }).toString().trim();
  assert.deepEqual((await daemon.get(`/v1/jobs/${id}`)).request, measured.request);
});

test("its files are fetched", async () => {
  const files = panel("Files");
  const saved = async (name) => {
    const [file] = await Promise.all([page.waitForEvent("download"), files.getByRole("button", { name }).click()]);
    return { name: file.suggestedFilename(), bytes: readFileSync(await file.path()) };
  };
  const exr = await saved("EXR, float");
  assert.equal(exr.name, `${measured.id}.exr`);
  assert.equal(exr.bytes.readUInt32LE(0), 20000630); // OpenEXR's own mark
  assert.equal((await saved("photon map")).bytes.toString("latin1", 0, 4), "glTF");
  assert.deepEqual(JSON.parse((await saved("Statistics")).bytes.toString()), measured.statistics);
  expectNoComplaints(page);
});

test("lives while it runs: progress, picture, curve; is steered; and goes on", async () => {
  const job = await daemon.submit(smallJob({ image: { width: 96, height: 96 }, stop: { seconds: 600, passes: 1_000_000 } }));
  const waiting = await daemon.submit(smallJob({ stop: { passes: 1 } }));
  await page.goto(`${daemon.url}/jobs/${job.id}`);
  await page.locator(".job-standing .state").getByText("running").waitFor();
  await panel("Image").locator(".picture-frame > img").first().waitFor();
  const shown = () => panel("Image").locator(".picture-frame > img").first().getAttribute("src");
  const first = await shown();
  await page.waitForFunction((old) => ![undefined, old].includes(document.querySelector(".job-picture .picture-frame > img")?.src), first);
  await panel("Error").locator("canvas").waitFor();
  await shoot(page, "job-running");
  await page.keyboard.press("c");
  await page.locator(".job-standing .state").getByText("cancelled").waitFor();
  const cancelled = await daemon.finished(job.id);
  assert.ok(cancelled.passes_done > 0);
  // Going on from its film, to an end it can reach.
  await page.getByRole("button", { name: "Extend" }).click();
  const dialog = page.getByRole("dialog");
  await dialog.getByLabel("After", { exact: true }).fill("x");
  await dialog.getByRole("button", { name: "Extend" }).click();
  await dialog.getByText('must be a whole number, got "x"').waitFor();
  await axeClean(await allowing(page, /status of 422/));
  await dialog.getByLabel("After", { exact: true }).fill(String(cancelled.passes_done + 5));
  await dialog.getByLabel("or after").fill("");
  await dialog.getByRole("button", { name: "Extend" }).click();
  await page.locator(".job-standing .state").getByText("succeeded").waitFor();
  await until(async () => assert.equal((await daemon.get(`/v1/jobs/${job.id}`)).passes_done, cancelled.passes_done + 5));
  await panel("State over time").getByText("attempt 2, going on").waitFor();
  // The next by its key.
  await page.keyboard.press("]");
  await page.waitForURL(`**/jobs/${waiting.id}`);
  await page.keyboard.press("[");
  await page.waitForURL(`**/jobs/${job.id}`);
});

test("a waiting job's priority is changed, and it is removed", async () => {
  await daemon.submit(smallJob({ image: { width: 128, height: 128 }, stop: { seconds: 600 } })); // keeps the worker busy
  const job = await daemon.submit(smallJob());
  await page.goto(`${daemon.url}/jobs/${job.id}`);
  await page.getByRole("button", { name: "Priority 0" }).click();
  await page.getByRole("dialog").getByLabel(/^Priority/).fill("42");
  await page.getByRole("dialog").getByRole("button", { name: "Set" }).click();
  await page.getByRole("button", { name: "Priority 42" }).waitFor();
  assert.equal((await daemon.get(`/v1/jobs/${job.id}`)).request.priority, 42);
  await page.getByRole("button", { name: "Remove" }).click();
  await page.getByRole("dialog").getByRole("button", { name: "Remove" }).click();
  await page.waitForURL("**/jobs");
  await until(async () => assert.equal((await fetch(`${daemon.url}/v1/jobs/${job.id}`)).status, 404));
});

test("a job that failed says why, and one that is not there says so", async () => {
  const failed = (await daemon.get("/v1/jobs?state=failed&limit=1")).items[0];
  await page.goto(`${daemon.url}/jobs/${failed.id}`);
  await page.getByRole("alert").getByText(failed.failure.detail).waitFor();
  await page.getByRole("button", { name: "Retry" }).waitFor();
  await shoot(page, "job-failed");
  await page.goto(`${daemon.url}/jobs/J99999`);
  await page.getByText("there is no job 'J99999'").waitFor();
});

test("fits a telephone", async () => {
  await page.setViewportSize({ width: 390, height: 844 });
  await page.goto(`${daemon.url}/jobs/${measured.id}`);
  await panel("Error").locator("canvas").waitFor();
  await panel("Image").locator(".picture-frame > img").first().waitFor();
  await fitsItsWidth(page);
  await shoot(page, "job-narrow");
});

/**
 * The page with the complaints of a request that was to be refused, or that found nothing, taken out. The browser may
 * complain a moment after the page has said so.
 */
async function allowing(of, pattern) {
  await until(() => assert.ok(of.complaints.some((text) => pattern.test(text)), `nothing like ${pattern}`));
  of.complaints = of.complaints.filter((text) => !pattern.test(text));
  return of;
}
