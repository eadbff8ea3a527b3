// Sequences: listed, played, stepped through, two on one clock.

import assert from "node:assert/strict";

import { afterEach, axeClean, fitsItsWidth, openPage, shoot, startDaemon, test, until } from "./support.mjs";

const daemon = await startDaemon();

afterEach(() => daemon.idle());

const ask = (more = {}) =>
  daemon.json("POST", "/v1/sequences", {
    scene: "moving/teleport",
    image: { width: 48, height: 48 },
    method: { name: "path_tracing" },
    stop: { passes: 4 },
    to: 1,
    fps: 4,
    ...more,
  });
const path = (id) => `/v1/sequences/${id}`;
const shownFrame = (page) => page.locator(".sequence-player figcaption a").first().innerText();

test("an empty list says what sequences are", async () => {
  const page = await openPage(daemon, "/sequences");
  await page.getByText("Nothing has been rendered frame by frame yet").waitFor();
  await axeClean(page);
});

test("a sequence is played and stepped through", async () => {
  const { id } = await ask();
  await daemon.succeeds(path(id));
  const page = await openPage(daemon, "/sequences");
  await page.getByRole("link", { name: id }).click();
  await page.locator(".sequence-frame img").waitFor();
  await until(async () => assert.equal(await page.locator(".sequence-frame img").evaluate((image) => image.complete && image.naturalWidth), 48));
  assert.equal(await shownFrame(page), "0");
  const first = await page.locator(".sequence-frame img").getAttribute("src");
  await page.keyboard.press("ArrowRight");
  await until(async () => assert.equal(await shownFrame(page), "1"));
  await page.keyboard.press("ArrowLeft");
  await page.keyboard.press("ArrowLeft");
  await until(async () => assert.equal(await shownFrame(page), "4"), "round to the last");
  await until(async () => assert.notEqual(await page.locator(".sequence-frame img").getAttribute("src"), first));
  await page.getByLabel("Time").fill("0.5");
  await until(async () => assert.equal(await shownFrame(page), "2"));
  await page.getByRole("button", { name: "Play" }).click();
  await until(async () => assert.notEqual(await shownFrame(page), "2"));
  await page.getByRole("button", { name: "Pause" }).click();
  await shoot(page, "sequence");
  await axeClean(page);
  await fitsItsWidth(page);
});

test("two sequences keep one clock", async () => {
  const [first, second] = [await ask(), await ask({ fps: 8, method: { name: "photon_mapping", parameters: { photons: 1000 } } })];
  for (const { id } of [first, second]) await daemon.succeeds(path(id));
  const page = await openPage(daemon, `/sequences/${first.id}`);
  await page.getByLabel("Beside it").selectOption(second.id);
  await until(async () => assert.equal(await page.locator(".sequence-frame img").count(), 2));
  await page.getByLabel("Time").fill("0.5");
  await until(async () => assert.deepEqual(await page.locator(".sequence-player figcaption a").allInnerTexts(), ["2", "4"]));
  await shoot(page, "sequences-two");
  assert.equal(new URL(page.url()).searchParams.get("beside"), second.id);
});

test("errors by frame are measured against two others", async () => {
  const [shown, first, second] = [await ask(), await ask({ seed: 1000, stop: { passes: 16 } }), await ask({ seed: 2000, stop: { passes: 16 } })];
  for (const { id } of [shown, first, second]) await daemon.succeeds(path(id));
  const page = await openPage(daemon, `/sequences/${shown.id}`);
  await page.getByLabel("First reference").selectOption(first.id);
  await page.getByLabel("Second reference").selectOption(second.id);
  await page.getByRole("img", { name: /^Flicker by frame; .* in the mean$/ }).waitFor();
  await page.getByText(/^Lag .*over 5 frames$/).waitFor();
  await shoot(page, "sequence-errors");
  await axeClean(page);
  await page.getByLabel("Second reference").selectOption(first.id);
  await page.getByText("their noise is not independent").waitFor();
});

test("a sequence under way is cancelled, and removed", async () => {
  const { id } = await ask({ stop: { seconds: 600 } });
  const page = await openPage(daemon, `/sequences/${id}`);
  await page.getByText("0 of 5 frames").waitFor();
  await page.getByRole("button", { name: "Cancel" }).click();
  await daemon.over(path(id));
  await page.getByRole("button", { name: "Remove with its frames" }).click();
  await until(() => assert.equal(new URL(page.url()).pathname, "/sequences"));
  const answer = await fetch(`${daemon.url}/v1/sequences/${id}`);
  await answer.arrayBuffer();
  assert.equal(answer.status, 404);
});
