// The form of a render: from nothing, from another job, and from its JSON.

import assert from "node:assert/strict";

import { axeClean, fitsItsWidth, openPage, shoot, smallJob, startDaemon, test, until } from "./support.mjs";
import { tinyGlb } from "./tiny_glb.mjs";

const daemon = await startDaemon();
const page = await openPage(daemon, "/render", { expected: /status of 422/ });
const estimate = page.locator(".render-estimate");
const json = () => page.getByLabel("The request as JSON");
/** A form says what it came to a moment after it is written into. */
const has = (field, value) => until(async () => assert.equal(await field.inputValue(), value));
const says = (path, value) => until(async () => assert.deepEqual(JSON.parse(await json().inputValue())[path], value));
const submitted = async () => {
  await page.getByRole("button", { name: "Render", exact: true }).click();
  await page.waitForURL(/\/jobs\/J\d+$/);
  return daemon.finished(page.url().split("/").at(-1));
};

test("a newcomer renders an image, seeing before what it takes", async () => {
  await estimate.getByText(/MB|kB/).waitFor();
  await page.locator(".render-thumbnail img").waitFor();
  await shoot(page, "render", { fullPage: true });
  await axeClean(page);
  await page.getByLabel("Width").fill("48");
  await page.getByLabel("Height").fill("32");
  await page.getByLabel("After", { exact: true }).fill("2");
  const job = await submitted();
  assert.equal(job.state, "succeeded");
  assert.deepEqual(job.request.image, { width: 48, height: 32, filter: "box" });
  assert.equal(job.request.stop.passes, 2);
});

test("every parameter of every method is in a group that says what it is about", async () => {
  await page.goto(`${daemon.url}/render`);
  const methods = (await daemon.get("/v1/methods")).items;
  for (const method of methods) {
    const option = page.locator(`#render-method-method option[value=${method.name}]`);
    await option.waitFor({ state: "attached" });
    if (await option.evaluate((element) => element.disabled)) {
      assert.deepEqual(method.devices, ["gpu"]); // which this daemon does not serve
      continue;
    }
    await page.locator("#render-method-method").selectOption(method.name);
    for (const name of Object.keys(method.parameters.properties)) await page.locator(`#render-method-${name}`).waitFor({ state: "attached" });
    assert.equal(await page.locator(".method-form-group summary").filter({ hasText: "Other" }).count(), 0, `${method.name} has parameters nobody has sorted`);
  }
});

test("parameters are checked at once in the daemon's words, and reset", async () => {
  await page.goto(`${daemon.url}/render?method=photon_mapping`);
  const photons = page.locator("#render-method-photons");
  await photons.fill("0");
  await page.locator("#render-method-photons-hint").getByText("0 is outside [1, 1e+09] photons").waitFor();
  await page.locator(".render-faults").getByText("photons: 0 is outside [1, 1e+09] photons").waitFor();
  await photons.fill("5000");
  await page.getByText("1 changed").first().waitFor();
  await page.locator(".render-json summary").click();
  await says("method", { name: "photon_mapping", parameters: { photons: 5000 } });
  await page.getByRole("button", { name: "Reset photons" }).click();
  await says("method", { name: "photon_mapping" });
  await has(photons, "");
});

test("every fault the daemon finds stands at its field", async () => {
  await page.goto(`${daemon.url}/render`);
  await page.getByLabel("Width").fill("wide");
  await page.getByLabel("After", { exact: true }).fill("");
  await page.locator("#render-width-about").getByText('must be a whole number, got "wide"').waitFor();
  await page.getByText("at least one of seconds, passes and target is required").first().waitFor();
  await page.getByRole("group", { name: "Sizes" }).getByRole("button", { name: "256 × 256" }).click();
  await page.getByLabel("or at an error of at most").fill("0.01");
  await page.locator(".render-more summary").click();
  await page.getByLabel("Labels").fill("=x");
  await page.locator("#render-labels-about").getByText(/a label's key has 1 to/).waitFor();
  await shoot(page, "render-faults");
  await axeClean(page);
  await page.locator(".render-faults").getByRole("button").first().click();
  await page.waitForFunction(() => document.activeElement.id === "render-labels");
  await page.getByLabel("Labels").fill("study=x");
  await estimate.getByText(/MB|kB/).waitFor();
  // What was changed is there after the page was loaded again, and is given up when one starts over.
  await page.reload();
  await has(page.getByLabel("Width"), "256");
  await page.getByRole("button", { name: "Start over" }).click();
  await has(page.getByLabel("Width"), "512");
  await page.getByRole("button", { name: "Start over" }).waitFor({ state: "detached" });
});

test("a job is cloned and changed: what is sent is what is shown", async () => {
  const first = await daemon.run(
    smallJob({
      camera: { look_at: { eye: [0, 2, 8], target: [0, 2, 0], up: [0, 1, 0], yfov: 0.8 }, aperture: 0.05 },
      method: { name: "photon_splatting", parameters: { photons: 300 } },
      stop: { passes: 3, seconds: 50 },
      reference: { method: { name: "path_tracing" }, stop: { passes: 4 } },
      metrics: ["flip_ldr"],
      layers: ["depth"],
      labels: { a: "b=c" },
      seed: 7,
    }),
  );
  await page.goto(`${daemon.url}/render?from=${first.id}`);
  await page.locator(".render-json summary").click();
  await has(page.locator("#render-method-photons"), "300");
  await page.locator("#render-seed").waitFor({ state: "attached" });
  const same = await submitted();
  assert.deepEqual(same.request, first.request);
  assert.equal(same.statistics.pixel_hash, first.statistics.pixel_hash);
  await page.goto(`${daemon.url}/render?from=${first.id}`);
  await page.locator(".render-more summary").click();
  await page.getByLabel("Seed").fill("8");
  await page.getByLabel("flip hdr").check();
  await page.locator("#render-eye-x").fill("0.5");
  const other = await submitted();
  assert.deepEqual(other.request, { ...first.request, seed: 8, metrics: ["flip_ldr", "flip_hdr"], camera: { ...first.request.camera, look_at: { ...first.request.camera.look_at, eye: [0.5, 2, 8] } } });
});

test("a view of the scene's page, and a scene by its name, are what the form starts with", async () => {
  await page.goto(`${daemon.url}/render?scene=keyhole&eye=0,1,4&target=0,1,0&yfov=0.6`);
  await page.locator(".render-json summary").click();
  await says("scene", "keyhole");
  await until(async () => assert.deepEqual(JSON.parse(await json().inputValue()).camera.look_at.target.map(Math.round), [0, 1, 0]));
  await has(page.getByLabel("Camera"), "own");
});

test("the size follows the shape that the camera asks for, and says so", async () => {
  const lens = { yfov: 0.7, znear: 0.01 };
  const body = tinyGlb({
    cameras: [{ type: "perspective", perspective: { ...lens, aspectRatio: 2 } }, { type: "perspective", perspective: lens }],
    nodes: [{ mesh: 0 }, { mesh: 1, translation: [0, 1, 0] }, { name: "wide", camera: 0, translation: [0, 0, 3] }, { name: "any", camera: 1, translation: [0, 0, 3] }],
    scenes: [{ nodes: [0, 1, 2, 3] }],
  });
  await daemon.upload("shaped", body);
  await page.goto(`${daemon.url}/render?scene=shaped`);
  await page.getByTestId("shape").filter({ hasText: "The size follows the camera, whose file asks for 2:1." }).waitFor();
  const size = async () => [await page.getByLabel("Width").inputValue(), await page.getByLabel("Height").inputValue()].map(Number);
  await until(async () => assert.equal((await size())[0], 2 * (await size())[1]));
  await page.getByLabel("Height").fill("100");
  await until(async () => assert.deepEqual(await size(), [200, 100]));
  await page.getByLabel("Keep the shape").uncheck();
  await page.getByLabel("Height").fill("200");
  await page.getByTestId("shape").filter({ hasText: "asks for 2:1: this image shows more at its sides, or less" }).waitFor();
  assert.deepEqual(await size(), [200, 200]);
  await page.getByRole("button", { name: "Take the camera’s, 2:1" }).click();
  await until(async () => assert.equal((await size())[0], 2 * (await size())[1]));
  await page.getByLabel("Camera").selectOption("any");
  await page.getByTestId("shape").filter({ hasText: "The camera asks for no shape" }).waitFor();
});

test("a scene that moves is rendered at a moment of it", async () => {
  const moment = page.getByRole("region", { name: "Moment" });
  await page.goto(`${daemon.url}/render?scene=keyhole`);
  await page.locator(".render-thumbnail img").waitFor();
  assert.equal(await moment.count(), 0); // where nothing moves there is none
  await page.goto(`${daemon.url}/render?scene=moving%2Fcornell-box`);
  await page.locator(".render-json summary").click();
  const animation = moment.getByLabel("Animation", { exact: true });
  await has(animation, "at rest");
  assert.equal(await moment.getByLabel("Time", { exact: true }).count(), 0);
  await animation.selectOption({ label: "everything" });
  await says("animation", "everything");
  await moment.getByText("4 s, moves 4 meshes, 1 camera").waitFor();
  const time = moment.getByLabel("Time", { exact: true });
  const slider = moment.getByLabel("Time in the animation");
  await time.fill("1.5");
  await says("time", 1.5);
  await has(slider, "1.5");
  await slider.press("ArrowRight");
  await has(time, "1.54");
  await slider.fill("2");
  await says("time", 2);
  await page.locator(".render-more summary").click();
  await page.getByLabel("Shutter").fill("0.02");
  await says("shutter", 0.02);
  // Where passes build on one another the daemon says that all show one moment.
  await page.locator("#render-method-method").selectOption("progressive_photon_mapping");
  await page.locator("#render-shutter-about").getByText(/build on those before/).waitFor();
  await page.locator("#render-method-method").selectOption("path_tracing");
  await estimate.getByText(/MB|kB/).waitFor();
  assert.ok(await page.getByLabel("Shutter").isVisible()); // a fault that is mended closes nothing
  await shoot(page, "render-moment", { fullPage: true });
  await axeClean(page);
  await page.getByLabel("Width").fill("48");
  await page.getByLabel("Height").fill("32");
  await page.getByLabel("After", { exact: true }).fill("2");
  const job = await submitted();
  assert.equal(job.state, "succeeded");
  assert.deepEqual([job.request.animation, job.request.time, job.request.shutter], ["everything", 2, 0.02]);
  await page.locator(".facts").getByText("2 s into “everything”, the shutter open for 20 ms").waitFor();
  // Cloned it is the same, at rest it says nothing, and its first moment is not that.
  await page.goto(`${daemon.url}/render?from=${job.id}`);
  await has(time, "2");
  await page.locator(".render-json summary").click();
  await time.fill("0");
  await says("time", undefined);
  await says("animation", "everything");
  await animation.selectOption("at rest");
  for (const member of ["animation", "time", "shutter"]) await says(member, undefined);
  await animation.selectOption({ label: "everything" });
  await page.getByRole("combobox", { name: "Scene", exact: true }).selectOption("keyhole");
  await says("animation", undefined);
  await moment.waitFor({ state: "detached" });
});

test("the JSON is another face of the form", async () => {
  await page.goto(`${daemon.url}/render`);
  await page.locator(".render-json summary").click();
  const text = JSON.stringify({ ...smallJob(), image: { width: 40, height: 30 }, method: { name: "photon_mapping", parameters: { gather: "direct", photons: 500 } } }, null, 2);
  await json().fill("{ not yet");
  await page.getByText(/This is no JSON/).waitFor();
  await json().fill(text);
  await has(page.getByLabel("Width"), "40");
  await has(page.locator("#render-method-gather"), "direct");
  await json().press("Control+Enter");
  await page.waitForURL(/\/jobs\/J\d+$/);
  const job = await daemon.finished(page.url().split("/").at(-1));
  assert.equal(job.request.method.parameters.photons, 500);
});

test("fits a telephone", async () => {
  await page.setViewportSize({ width: 390, height: 844 });
  await page.goto(`${daemon.url}/render`);
  await estimate.getByText(/MB|kB/).waitFor();
  await fitsItsWidth(page);
  await shoot(page, "render-narrow", { fullPage: true });
  await axeClean(page);
  await page.goto(`${daemon.url}/render?scene=moving%2Fcornell-box&animation=everything&time=1.5`);
  await has(page.getByLabel("Time", { exact: true }), "1.5");
  await estimate.getByText(/MB|kB/).waitFor();
  await fitsItsWidth(page);
  await shoot(page, "render-moment-narrow", { fullPage: true });
});
