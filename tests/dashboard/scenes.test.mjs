// Scenes: found, brought, looked at from anywhere, deleted.

import assert from "node:assert/strict";

import { CountingProxy } from "./counting_proxy.mjs";
import { afterEach, axeClean, expectNoComplaints, fitsItsWidth, kTelephone, openPage, shoot, smallJob, startDaemon, test, until } from "./support.mjs";
import { tinyGlb, tinyGltf } from "./tiny_glb.mjs";

const daemon = await startDaemon();

afterEach(() => daemon.idle());

/** The first of the cards come to be these. */
const cardsAre = (page, names) =>
  until(async () => assert.deepEqual((await page.locator(".scenes-card:not(.scenes-waits) strong").allInnerTexts()).slice(0, names.length), names));
const listed = (page, count) => page.waitForFunction((wanted) => document.querySelectorAll(".scenes-card:not(.scenes-waits)").length === wanted, count);
const query = (page) => Object.fromEntries(new URL(page.url()).searchParams);
const numbers = (text) => text.split(",").map(Number);

/** Drops files on the page as a desktop would. */
async function drop(page, files) {
  const transfer = await page.evaluateHandle((list) => {
    const data = new DataTransfer();
    for (const { name, bytes } of list) data.items.add(new File([Uint8Array.from(bytes)], name));
    return data;
  }, files.map(({ name, content }) => ({ name, bytes: [...content] })));
  await page.dispatchEvent("main", "dragenter", { dataTransfer: transfer });
  await page.locator(".scenes-drop").waitFor();
  await page.dispatchEvent("main", "drop", { dataTransfer: transfer });
  await page.locator(".scenes-drop").waitFor({ state: "detached" });
}

test("the gallery shows what there is, and its address says what is looked for", async () => {
  const page = await openPage(daemon, "/scenes");
  await listed(page, 8);
  await cardsAre(page, ["cornell-box", "cornell-box-spot"]);
  const first = page.locator(".scenes-card img").first();
  await first.waitFor();
  await until(async () => assert.equal(await first.evaluate((image) => image.complete && image.naturalWidth), 256));
  await shoot(page, "scenes");
  await axeClean(page);

  await page.keyboard.press("/");
  await page.keyboard.type("box gl");
  await listed(page, 2);
  await page.getByLabel("Order").selectOption("triangles");
  await cardsAre(page, ["cornell-box-glass", "cornell-box-glossy"]);
  await until(() => assert.deepEqual(query(page), { q: "box gl", sort: "triangles" }));
  await page.reload();
  await listed(page, 2);
  await cardsAre(page, ["cornell-box-glass", "cornell-box-glossy"]);
  await until(async () => assert.equal(await page.getByLabel("Search").inputValue(), "box gl"));

  await page.getByLabel("Search").fill("no such");
  await page.getByText("No scene has “no such” in its name.").waitFor();
  expectNoComplaints(page);
});

test("families of scenes, and a scene whose name has a slash, have their addresses", async () => {
  // The pictures of all these scenes are not what is looked at, and dear: they are held.
  const proxy = await CountingProxy.before(daemon);
  proxy.hold();
  const page = await openPage({ url: proxy.url }, "/scenes?q=no+such");
  for (const [family, scenes] of [["Details of rooms", 7], ["Caustics", 1], ["Progressive photon mapping", 6], ["Moving", 6], ["Photon splatting's figures", 3]]) {
    await page.getByRole("link", { name: family }).click();
    await listed(page, scenes);
  }
  const { paths } = await daemon.get("/v1/openapi.json");
  const families = paths["/v1/scenes"].get.parameters.find(({ name }) => name === "family").schema.enum;
  for (const family of families) assert.equal(await page.locator(`.scenes-families a[href="/scenes?family=${family}"]`).count(), 1, family);
  await page.getByRole("link", { name: "Photon splatting's figures" }).click();
  await page.getByRole("link", { name: "photon-splatting/plate" }).click();
  await page.getByRole("heading", { level: 1, name: "photon-splatting/plate" }).waitFor();
  await until(() => assert.equal(new URL(page.url()).pathname, "/scenes/photon-splatting%2Fplate"));
  // The daemon itself serves the page for a name with a slash.
  await page.reload();
  await page.getByRole("heading", { level: 1, name: "photon-splatting/plate" }).waitFor();
  expectNoComplaints(page);
});

test("scenes are brought by a drop or by choice, and what is wrong with one is said", async () => {
  const page = await openPage(daemon, "/scenes", { expected: /status of 4/ });
  await listed(page, 8);
  await drop(page, [{ name: "squares.glb", content: tinyGlb() }]);
  await page.getByText("squares is here.").waitFor();
  await listed(page, 9);
  await cardsAre(page, ["squares"]);

  // The same bytes again are the same scene.
  await drop(page, [{ name: "squares again.glb", content: tinyGlb() }]);
  await page.getByText("was here already").waitFor();

  await page.locator('input[type="file"]').first().setInputFiles(tinyGltf("loose", { asset: { version: "2.0", generator: "loose" } }).map(({ name, content }) => ({ name, mimeType: "application/octet-stream", buffer: content })));
  await page.getByText("loose is here.").waitFor();
  await listed(page, 10);

  const broken = tinyGlb({ meshes: [{ primitives: [{ attributes: { POSITION: 7 } }] }, { primitives: [{ attributes: { POSITION: 0 }, indices: 9 }] }] });
  await drop(page, [{ name: "broken.glb", content: broken }]);
  const faults = page.locator(".scenes-upload.failed", { hasText: "broken" });
  await faults.waitFor();
  await until(async () => assert.match(await faults.innerText(), /\/meshes\/0\/primitives\/0/));
  await drop(page, [{ name: "notes.txt", content: Buffer.from("?") }]);
  await page.getByText("notes.txt is not a scene").waitFor();
  await shoot(page, "scenes-uploads");
  await axeClean(page);
});

test("a scene is looked at from anywhere, and its address brings the view back", async () => {
  const page = await openPage(daemon, "/scenes/cornell-box");
  const stage = page.getByRole("application", { name: "View of the scene" });
  const image = stage.locator("img");
  await image.waitFor();
  await page.getByText(/512 × 384, 16 passes in/).waitFor();
  await page.getByText("Preview, filtered").waitFor();
  const exact = await image.getAttribute("src");
  await page.locator(".scene-cameras img").waitFor();
  await shoot(page, "scene");
  await axeClean(page);

  const box = await stage.boundingBox();
  const middle = { x: box.x + box.width / 2, y: box.y + box.height / 2 };
  await page.mouse.move(middle.x, middle.y);
  await page.mouse.down();
  for (let step = 1; step <= 10; ++step) await page.mouse.move(middle.x + 6 * step, middle.y + 3 * step);
  await page.mouse.up();
  // The link leads to the view as it is; the address follows once that is at rest, which it may have seemed before.
  const forward = page.getByRole("link", { name: "Render from here" });
  const atRest = () =>
    until(async () => {
      const now = query(page);
      const linked = new URL(await forward.getAttribute("href"), page.url()).searchParams;
      assert.ok(now.eye);
      const { width, height, exposure, curve, ...view } = Object.fromEntries(linked);
      assert.deepEqual(view, { scene: "cornell-box", ...now });
      // In the shape of the picture and by its exposure.
      assert.ok(Math.abs(width / height / (4 / 3) - 1) < 0.01, `${width} × ${height}`);
      assert.ok(Number(exposure) !== 0 && curve === "filmic", `${exposure} ${curve}`);
      return now;
    });
  const orbited = await atRest();
  assert.equal(orbited.camera, undefined);
  await page.waitForFunction((before) => document.querySelector(".scene-picture img")?.getAttribute("src") !== before, exact);

  const distance = ({ eye, target }) => Math.hypot(...numbers(eye).map((value, k) => value - numbers(target)[k]));
  await page.mouse.wheel(0, -300);
  await page.waitForFunction((before) => new URLSearchParams(location.search).get("eye") !== before, orbited.eye);
  const nearer = await atRest();
  assert.equal(nearer.target, orbited.target);
  assert.ok(Math.abs(distance(nearer) / distance(orbited) - 1.1 ** -3) < 1e-3);

  await stage.focus();
  await page.keyboard.press("Shift+ArrowLeft");
  await page.waitForFunction((before) => new URLSearchParams(location.search).get("target") !== before, nearer.target);
  const panned = await atRest();
  assert.ok(Math.abs(distance(panned) - distance(nearer)) < 1e-3);

  await page.getByText(/512 × 384, 16 passes in/).waitFor();
  assert.deepEqual(await atRest(), panned);
  await page.getByRole("button", { name: "Copy camera" }).click();
  await page.getByText("The camera is copied").waitFor();
  const { look_at } = JSON.parse(await page.evaluate(() => navigator.clipboard.readText()));
  assert.deepEqual(look_at.eye, numbers(panned.eye));
  // A job takes what was copied.
  const job = await daemon.run(smallJob({ camera: { look_at }, image: { width: 16, height: 16 }, stop: { passes: 1 } }));
  assert.deepEqual(job.request.camera.look_at.target, numbers(panned.target));

  await page.reload();
  await image.waitFor();
  assert.deepEqual(await atRest(), panned);
  await page.getByText(/512 × 384, 16 passes in/).waitFor();
  await shoot(page, "scene-before-render");
  const wanted = new URL(await forward.getAttribute("href"), page.url()).searchParams;
  await forward.click();
  await page.getByTestId("shown-by").filter({ hasText: /will be shown at [+−]?[\d.]+ stops, filmic, as the view was/ }).waitFor();
  await until(async () => assert.deepEqual([await page.getByLabel("Width").inputValue(), await page.getByLabel("Height").inputValue()], [wanted.get("width"), wanted.get("height")]));
  // One side follows the other.
  await page.getByLabel("Width").fill("96");
  await until(async () => assert.equal(await page.getByLabel("Height").inputValue(), "72"));
  await page.locator("#render-stop-passes").fill("4");
  await page.getByRole("button", { name: "Render", exact: true }).click();
  await page.waitForURL(/\/jobs\/J\d+/);
  assert.equal(query(page).exposure, wanted.get("exposure"));
  assert.equal(query(page).curve, "filmic");
  const rendered = await daemon.get(`/v1/jobs/${new URL(page.url()).pathname.split("/").at(-1)}`);
  assert.deepEqual(rendered.request.camera.look_at.eye, numbers(panned.eye));
  assert.deepEqual([rendered.request.image.width, rendered.request.image.height], [96, 72]);
  await page.locator(".job-picture img").first().waitFor();
  await shoot(page, "scene-rendered-from-here");
  await page.goto(daemon.url + "/scenes/cornell-box?" + new URLSearchParams(panned));
  await image.waitFor();
  assert.deepEqual(await atRest(), panned);
  await page.getByRole("button", { name: /^camera/ }).click();
  await page.waitForFunction(() => new URLSearchParams(location.search).get("camera") === "camera");
  await page.getByRole("button", { name: /^camera/, pressed: true }).waitFor();
  await page.goBack();
  await page.waitForFunction((eye) => new URLSearchParams(location.search).get("eye") === eye, panned.eye);
  await page.getByRole("button", { name: /^camera/, pressed: false }).waitFor();
  expectNoComplaints(page);
});

test("a scene is deleted once nothing needs it, and an unknown one is said to be none", async () => {
  const { id } = (await daemon.get("/v1/scenes")).items.find(({ name }) => name === "squares");
  const page = await openPage(daemon, `/scenes/${id}`, { expected: /status of 4/, width: 390, height: 844 });
  await page.getByText(/16 passes in/).waitFor();
  await page.getByText("The file has none").waitFor();
  await fitsItsWidth(page);
  await shoot(page, "scene-narrow", { fullPage: true });

  // Only now: beside a job the picture above would be drawn with what the job leaves.
  const job = await daemon.submit(smallJob({ scene: id, stop: { seconds: 600 } }));
  await page.getByRole("button", { name: "Delete …" }).click();
  await page.getByRole("button", { name: "Delete", exact: true }).click();
  await page.getByRole("link", { name: "Show those jobs" }).waitFor();
  await axeClean(page);
  await daemon.json("DELETE", `/v1/jobs/${job.id}`);
  await daemon.finished(job.id);
  await page.getByRole("button", { name: "Delete", exact: true }).click();
  await page.waitForURL("**/scenes");
  await page.getByText("squares is deleted.").waitFor();

  await page.goto(`${daemon.url}/scenes/no-such-scene`);
  await page.getByRole("heading", { name: "No such scene" }).waitFor();
  expectNoComplaints(page);
});

test("two fingers pan a view, and a pinch comes nearer", async () => {
  const page = await openPage(daemon, "/scenes/cornell-box", kTelephone);
  const picture = page.locator(".scene-picture");
  await picture.locator("img").waitFor();
  const { x, y, width, height } = await picture.boundingBox();
  const fingers = await page.context().newCDPSession(page);
  const at = (...points) => points.map(([right, down], id) => ({ id, x: x + right * width, y: y + down * height }));
  const gesture = async (from, to) => {
    await fingers.send("Input.dispatchTouchEvent", { type: "touchStart", touchPoints: at(...from) });
    for (let step = 1; step <= 8; ++step) {
      const points = from.map((point, finger) => point.map((value, axis) => value + (step / 8) * (to[finger][axis] - value)));
      await fingers.send("Input.dispatchTouchEvent", { type: "touchMove", touchPoints: at(...points) });
    }
    await fingers.send("Input.dispatchTouchEvent", { type: "touchEnd", touchPoints: [] });
  };
  const orbit = () =>
    until(() => {
      const members = query(page);
      assert.ok(members.eye && members.target);
      const [eye, target] = [members.eye, members.target].map((text) => text.split(",").map(Number));
      return { target, way: eye.map((value, axis) => value - target[axis]) };
    });
  await gesture([[0.4, 0.5], [0.6, 0.5]], [[0.5, 0.5], [0.7, 0.5]]);
  const panned = await orbit();
  assert.ok(panned.target[0] < -0.1, `the target goes to the left: ${panned.target}`);
  await gesture([[0.4, 0.5], [0.6, 0.5]], [[0.3, 0.5], [0.7, 0.5]]);
  const pinched = await until(async () => {
    const now = await orbit();
    assert.ok(Math.hypot(...now.way) < 0.6 * Math.hypot(...panned.way), "nearer");
    return now;
  });
  const moved = Math.hypot(...pinched.target.map((value, axis) => value - panned.target[axis]));
  assert.ok(moved < 0.05 * Math.hypot(...pinched.way), `a pinch about the middle does not pan: ${panned.target} became ${pinched.target}`);
  expectNoComplaints(page);
});
