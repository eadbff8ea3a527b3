// Images compared: what is painted is what the daemon says of the same pixels, everything works by keys and by controls,
// and a link brings the same picture back.

import assert from "node:assert/strict";
import { readFileSync } from "node:fs";

import { exrFile } from "./exr_file.mjs";
import { afterEach, axeClean, expectNoComplaints, fitsItsWidth, openPage, shoot, smallJob, startDaemon, test, until } from "./support.mjs";

const daemon = await startDaemon();
afterEach(() => daemon.idle());
const kSide = 48;
const layers = ["normal", "depth"];
const reference = await daemon.run(smallJob({ stop: { passes: 32 }, layers }));
const compared = { reference: `job:${reference.id}`, metrics: ["relative_mse"], layers };
const noisy = await daemon.run(smallJob({ stop: { passes: 2 }, ...compared }));
const photons = await daemon.run(smallJob({ method: { name: "photon_mapping" }, stop: { passes: 2 }, ...compared }));
const all = [reference, noisy, photons].map((job) => `job:${job.id}`);

const addressOf = (members) => `/compare?${new URLSearchParams({ images: all.join(","), ...members })}`;
const query = (page) => Object.fromEntries(new URL(page.url()).searchParams);
/** As the view stands; the address follows it a moment later. */
const addressSays = (page, name, value) => page.waitForFunction(([key, wanted]) => new URL(location.href).searchParams.get(key) === wanted, [name, value]);

const choice = (page, name) => page.getByRole("combobox", { name, exact: true });

/** All pixels are there, those of the reference too, and drawn. */
async function settled(page) {
  await page.locator(".compare-pane").first().waitFor();
  await page.waitForFunction(() => !document.querySelector(".compare-busy") && ![...document.querySelectorAll(".compare-note")].some((note) => note.textContent.includes("is not there yet")));
  await page.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))));
}

async function open(members, options) {
  const page = await openPage(daemon, addressOf(members), options);
  await settled(page);
  return page;
}

/** Pixels of a 2D context of the page as text; as a list of numbers they would take seconds. */
const kAsText = `(context, x, y, w, h) => {
  const data = context.getImageData(x, y, w, h).data;
  let text = "";
  for (let at = 0; at < data.length; at += 32768) text += String.fromCharCode(...data.subarray(at, at + 32768));
  return btoa(text);
}`;

/** RGBA of the picture on the stage, `width` by `height` device pixels about its middle. */
async function painted(page, width, height = width) {
  const text = await page.evaluate(`(() => {
    const canvas = document.querySelector(".compare-stage > canvas");
    return (${kAsText})(canvas.getContext("2d"), Math.round(canvas.width / 2 - ${width} / 2), Math.round(canvas.height / 2 - ${height} / 2), ${width}, ${height});
  })()`);
  return Buffer.from(text, "base64");
}

/** RGBA of a picture of the daemon. */
async function pictureAt(page, path) {
  const text = await page.evaluate(`(async () => {
    const answer = await fetch("${path}");
    if (!answer.ok) throw new Error("${path}: " + answer.status + " " + (await answer.text()));
    const bitmap = await createImageBitmap(await answer.blob(), { colorSpaceConversion: "none" });
    const context = new OffscreenCanvas(bitmap.width, bitmap.height).getContext("2d");
    context.drawImage(bitmap, 0, 0);
    return (${kAsText})(context, 0, 0, bitmap.width, bitmap.height);
  })()`);
  return Buffer.from(text, "base64");
}

async function floats(path) {
  const answer = await fetch(daemon.url + path);
  assert.equal(answer.status, 200, path);
  return new Float32Array(await answer.arrayBuffer());
}

/** Of 0 to 255: the greatest difference, and how many values differ. */
function differences(a, b) {
  assert.equal(a.length, b.length);
  let greatest = 0;
  let differing = 0;
  for (let i = 0; i < a.length; ++i) {
    const difference = Math.abs(a[i] - b[i]);
    greatest = Math.max(greatest, difference);
    if (difference) ++differing;
  }
  return { greatest, share: differing / a.length };
}

/** CIE lightness of a display colour. */
function lightness(rgb) {
  const linear = [...rgb].map((value) => (value / 255 <= 0.04045 ? value / 255 / 12.92 : ((value / 255 + 0.055) / 1.055) ** 2.4));
  const y = 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2];
  return y > 0.008856 ? 116 * Math.cbrt(y) - 16 : 903.3 * y;
}

/** Drops files on the page as a desktop would. */
async function drop(page, files) {
  const transfer = await page.evaluateHandle(
    (list) => {
      const data = new DataTransfer();
      for (const { name, bytes } of list) data.items.add(new File([Uint8Array.from(bytes)], name));
      return data;
    },
    files.map(({ name, content }) => ({ name, bytes: [...content] })),
  );
  await page.dispatchEvent(".compare", "dragover", { dataTransfer: transfer });
  await page.locator(".compare-dropping").waitFor();
  await page.dispatchEvent(".compare", "drop", { dataTransfer: transfer });
}

const oneToOne = { zoom: "1", at: `${kSide / 2},${kSide / 2}` };

test("the room begins with jobs that are worth a look beside each other", async () => {
  const page = await openPage(daemon, "/compare");
  await page.getByRole("link", { name: "Compare these 3 images of cornell-box, 48 × 48" }).waitFor();
  await page.waitForFunction(() => [...document.querySelectorAll(".compare-jobs img")].filter((image) => image.complete && image.naturalWidth).length === 3);
  await shoot(page, "compare-start");
  await axeClean(page);
  await page.getByRole("link", { name: "Compare these 3 images" }).click();
  await settled(page);
  assert.equal(await page.locator(".compare-images > li").count(), 3);
  await until(() => assert.deepEqual(query(page).images.split(",").sort(), [...all].sort()));
  // The one that the others were measured against is the reference by itself, once it is known what they are.
  await page.locator(".compare-images > li", { has: page.getByRole("radio", { checked: true }), hasText: reference.id }).waitFor();
  expectNoComplaints(page);
});

test("the picture is the daemon's preview, by exposure, curve and zoom", async () => {
  const page = await open({ ...oneToOne, show: "3" });
  const equal = (path, width, height) =>
    until(async () => {
      const { greatest, share } = differences(await painted(page, width, height), await pictureAt(page, path));
      assert.ok(greatest <= 1 && share < 0.02, `${path}: by up to ${greatest}, in ${100 * share} % of the values`);
    });
  const preview = `/v1/jobs/${photons.id}/preview.png`;
  await equal(preview, kSide);
  await page.getByLabel("Exposure in stops").fill("1.5");
  await settled(page);
  await equal(`${preview}?exposure=1.5`, kSide);
  await choice(page, "View transform").selectOption("filmic");
  await settled(page);
  await equal(`${preview}?exposure=1.5&curve=filmic`, kSide);
  await choice(page, "Layer").selectOption("indirect");
  await settled(page);
  await equal(`${preview}?exposure=1.5&curve=filmic&layer=indirect`, kSide);
  // Below pixel for pixel it is the mean of the light, not of display colours.
  await page.goto(daemon.url + addressOf({ show: "3", zoom: "0.5", at: "24,24" }));
  await settled(page);
  await equal(`${preview}?max_size=24`, 24);
  await page.goto(daemon.url + addressOf({ show: "3", zoom: "0.3333333", at: "24,24" }));
  await settled(page);
  await equal(`${preview}?max_size=16`, 16);
  // Above it each pixel is a square.
  await page.goto(daemon.url + addressOf({ show: "3", zoom: "5", at: "24,24" }));
  await settled(page);
  const large = await painted(page, 5 * kSide);
  const small = await pictureAt(page, preview);
  for (let y = 0; y < 5 * kSide; ++y)
    for (let x = 0; x < 5 * kSide; ++x)
      for (let k = 0; k < 3; ++k) {
        const is = large[4 * (y * 5 * kSide + x) + k];
        const wanted = small[4 * (Math.floor(y / 5) * kSide + Math.floor(x / 5)) + k];
        assert.ok(Math.abs(is - wanted) <= 1, `pixel ${x}, ${y}: ${is} for ${wanted}`);
      }
  expectNoComplaints(page);
});

test("error maps are the daemon's, and the signed one is what the float pixels say", async () => {
  const page = await open({ ...oneToOne, show: "2", error: "relative", precision: "float" });
  const relative = differences(await painted(page, kSide), await pictureAt(page, `/v1/jobs/${noisy.id}/error.png`));
  assert.ok(relative.share < 0.01 && relative.greatest <= 4, JSON.stringify(relative));
  // Half floats are good to 1 in 2048: an entry of the scale at most.
  await choice(page, "Precision").selectOption("half");
  await settled(page);
  const half = differences(await painted(page, kSide), await pictureAt(page, `/v1/jobs/${noisy.id}/error.png`));
  assert.ok(half.share < 0.2 && half.greatest <= 24, JSON.stringify(half));

  await choice(page, "Error").selectOption("flip_hdr");
  await settled(page);
  const flip = differences(await painted(page, kSide), await pictureAt(page, `/v1/jobs/${noisy.id}/flip.png`));
  assert.ok(flip.share < 0.05 && flip.greatest <= 8, JSON.stringify(flip));
  await until(async () => assert.deepEqual(await page.locator(".compare-ticks span").allInnerTexts(), ["0", "0.25", "0.5", "0.75", "1"]));

  await choice(page, "Error").selectOption("signed");
  await page.getByLabel("Signed error at the ends of the scale").fill("0.2");
  await settled(page);
  await until(async () => assert.deepEqual(await page.locator(".compare-ticks span").allInnerTexts(), ["−0.2", "−0.1", "0", "+0.1", "+0.2"]));
  const [x, r] = await Promise.all([noisy, reference].map((job) => floats(`/v1/jobs/${job.id}/pixels`)));
  const shown = await painted(page, kSide);
  let signs = 0;
  for (let i = 0; i < kSide * kSide; ++i) {
    const error = 0.2126 * (x[3 * i] - r[3 * i]) + 0.7152 * (x[3 * i + 1] - r[3 * i + 1]) + 0.0722 * (x[3 * i + 2] - r[3 * i + 2]);
    const rgb = shown.subarray(4 * i, 4 * i + 3);
    const expected = 2 + 92 * Math.min(1, Math.abs(error) / 0.2);
    assert.ok(Math.abs(lightness(rgb) - expected) < 1.5, `pixel ${i}: error ${error}, lightness ${lightness(rgb)} for ${expected}`);
    if (Math.abs(error) < 0.02) continue;
    assert.equal(rgb[0] > rgb[2], error > 0, `pixel ${i}: error ${error} is ${[...rgb]}`);
    ++signs;
  }
  assert.ok(signs > 100, `only ${signs} pixels differ enough to be told by colour`);
  // The reference has no error: it is seen as it is.
  await page.locator(".compare-stage").focus();
  await page.keyboard.press("0");
  await settled(page);
  assert.ok(differences(await painted(page, kSide), await pictureAt(page, `/v1/jobs/${reference.id}/preview.png`)).greatest <= 1);
  // What was measured says the same as the map: FLIP's mean, beside the other metrics.
  await page.getByRole("button", { name: "Measure FLIP too" }).click();
  const row = page.getByRole("row", { name: new RegExp(`2 ${noisy.id}`) }).last();
  await page.waitForFunction(() => {
    const cells = [...document.querySelectorAll("[aria-label='Errors of the images'] td")];
    return cells.length === 10 && !cells.some((cell) => /[…–]/.test(cell.textContent));
  });
  const measured = (await daemon.json("POST", "/v1/metrics", { image: all[1], reference: all[0], metrics: ["relative_mse", "flip_hdr"] })).metrics;
  const cells = (await row.locator("td").allInnerTexts()).map((text) => Number.parseFloat(text));
  assert.ok(Math.abs(cells[0] / measured.relative_mse - 1) < 0.01 && Math.abs(cells[4] / measured.flip_hdr - 1) < 0.01, `${cells} for ${JSON.stringify(measured)}`);
  expectNoComplaints(page);
});

test("dropped EXR files are compared; NaN is magenta, infinity striped cyan, and neither is averaged away", async () => {
  const [width, height] = [16, 8];
  const plain = { R: new Float32Array(128).fill(0.5), G: new Float32Array(128).fill(0.25), B: new Float32Array(128).fill(0.125), "depth.Z": new Float32Array(128).fill(3) };
  const faulty = { R: plain.R.slice(), G: plain.G.slice(), B: plain.B.slice() };
  faulty.G[2 * width + 3] = NaN;
  faulty.R[4 * width + 5] = Infinity;
  faulty.B[6 * width + 9] = -Infinity;
  faulty.R[7 * width + 15] = 70000;
  const page = await openPage(daemon, "/compare");
  await drop(page, [{ name: "plain.exr", content: exrFile(width, height, plain) }, { name: "faulty.exr", content: exrFile(width, height, faulty) }]);
  await page.getByText("faulty.exr is there").waitFor();
  await page.locator(".compare-dropping").waitFor({ state: "detached" });
  await settled(page);
  await until(async () => assert.deepEqual(await page.locator(".compare-title").allInnerTexts(), ["plain.exr", "faulty.exr"]));
  await page.getByText("Pixels that are not finite: 1 NaN, 3 ∞").waitFor(); // 70000 is beyond half precision
  await page.getByText("Values beyond half precision: 1.").waitFor();
  await choice(page, "Precision").selectOption("float");
  await page.getByText("Pixels that are not finite: 1 NaN, 2 ∞").waitFor();

  const zoom = 10;
  await addressSays(page, "precision", "float");
  const images = query(page).images;
  const at = { images, precision: "float", show: "2", at: `${width / 2},${height / 2}` };
  await page.goto(daemon.url + addressOf({ ...at, zoom: String(zoom) }));
  await settled(page);
  const large = await painted(page, width * zoom, height * zoom);
  const colours = (x, y) => {
    const found = new Set();
    for (let dy = 0; dy < zoom; ++dy)
      for (let dx = 0; dx < zoom; ++dx) found.add([...large.subarray(4 * ((y * zoom + dy) * width * zoom + x * zoom + dx)).subarray(0, 3)].join());
    return found;
  };
  assert.deepEqual([...colours(3, 2)], ["255,0,255"]);
  assert.deepEqual([...colours(0, 0)], ["188,137,99"]);
  assert.ok(colours(5, 4).has("0,255,255") && colours(5, 4).size > 1, `infinity is ${[...colours(5, 4)]}`);
  assert.ok(colours(9, 6).has("0,102,115") && colours(9, 6).size > 1, `negative infinity is ${[...colours(9, 6)]}`);
  assert.deepEqual([...colours(15, 7)], ["255,137,99"]);

  await page.goto(daemon.url + addressOf({ ...at, zoom: "0.25" }));
  await settled(page);
  const small = await painted(page, 4, 2);
  const pixel = (x, y) => [...small.subarray(4 * (4 * y + x), 4 * (4 * y + x) + 3)];
  assert.deepEqual([pixel(0, 0), pixel(1, 1), pixel(2, 1), pixel(1, 0)], [[255, 0, 255], [0, 255, 255], [0, 102, 115], [188, 137, 99]]);

  // In an error map too; and a channel that is not looked at does not count.
  await page.goto(daemon.url + addressOf({ ...at, zoom: String(zoom), error: "relative", pixel: "3,2" }));
  await settled(page);
  const errors = await painted(page, width * zoom, height * zoom);
  const errorAt = (x, y) => [...errors.subarray(4 * ((y * zoom + 5) * width * zoom + x * zoom + 3)).subarray(0, 3)].join();
  assert.equal(errorAt(3, 2), "255,0,255");
  assert.ok(lightness(errorAt(0, 0).split(",").map(Number)) < 3);
  await page.getByRole("region", { name: "Values of the pixel" }).getByRole("row").nth(2).filter({ hasText: /0\.5\s*NaN\s*0\.125/ }).waitFor();
  await choice(page, "Channel").selectOption("r");
  await settled(page);
  const red = await painted(page, width * zoom, height * zoom);
  assert.ok(lightness(red.subarray(4 * (25 * width * zoom + 33)).subarray(0, 3)) < 3, "R is not NaN there");
  await choice(page, "Layer").selectOption({ label: "depth (1 of 2)" });
  await page.getByText("faulty.exr has no layer depth").waitFor();
  expectNoComplaints(page);

  const wrong = await openPage(daemon, "/compare", { expected: /400|415|422/ });
  await drop(wrong, [{ name: "photo.jpg", content: Buffer.from("no") }, { name: "broken.exr", content: Buffer.from("no EXR at all") }]);
  await wrong.getByText(/photo\.jpg: .*OpenEXR/).waitFor();
  await wrong.getByRole("alert").filter({ hasText: "broken.exr: " }).waitFor();
  expectNoComplaints(wrong);
});

test("view transforms, false colours, automatic exposure and the histogram are of known light", async () => {
  // Grey 0.18, grey 1, an orange highlight, a blue one: what a display is sent for them by the published formulas.
  const light = [[0.18, 0.18, 0.18], [1, 1, 1], [8, 0.5, 0.0625], [0.5, 0.25, 2]];
  const shown = {
    srgb: ["118,118,118", "255,255,255", "255,188,71", "188,137,255"],
    aces: ["91,91,91", "206,206,206", "255,205,130", "172,121,233"],
    agx: ["127,127,127", "201,201,201", "255,191,160", "178,156,228"],
    neutral: ["105,105,105", "240,240,240", "254,193,189", "154,128,250"],
  };
  const [width, height, zoom] = [8, 2, 16];
  const channel = (k) => Float32Array.from({ length: width * height }, (_, i) => light[Math.floor((i % width) / 2)][k]);
  const page = await openPage(daemon, "/compare");
  await drop(page, [{ name: "known.exr", content: exrFile(width, height, { R: channel(0), G: channel(1), B: channel(2) }) }]);
  await page.getByText("known.exr is there").waitFor();
  await settled(page);
  await until(() => assert.ok(query(page).images));
  const address = { images: query(page).images, precision: "float", zoom: String(zoom), at: `${width / 2},${height / 2}` };
  const colours = async () => {
    const large = await painted(page, width * zoom, height * zoom);
    return light.map((_, i) => [...large.subarray(4 * (zoom * width * zoom + (2 * i + 1) * zoom)).subarray(0, 3)]);
  };
  const near = (found, wanted) => found.every((colour, i) => colour.every((value, k) => Math.abs(value - Number(wanted[i].split(",")[k])) <= 1));
  await page.goto(daemon.url + addressOf(address));
  await settled(page);
  for (const [curve, wanted] of Object.entries(shown)) {
    await choice(page, "View transform").selectOption(curve);
    await until(async () => {
      const found = await colours();
      assert.ok(near(found, wanted), `${curve}: ${found.join(" ")} for ${wanted.join(" ")}`);
    });
  }
  await addressSays(page, "curve", "neutral");

  // False colours: the log of luminance, middle grey in the middle of the map, by any of them.
  const middles = new Set();
  for (const map of ["viridis", "magma", "turbo", "grey"]) {
    await choice(page, "Colours").selectOption(map);
    await addressSays(page, "colours", map);
    await settled(page);
    const [grey, white] = await colours();
    middles.add(grey.join());
    if (map === "viridis") assert.ok(near([grey], ["33,145,140"]) || grey[1] > 130, `viridis in its middle: ${grey}`);
    if (map === "grey") assert.ok(Math.abs(grey[0] - 119) <= 2 && grey[0] === grey[1] && white[0] > grey[0], `${grey} ${white}`);
  }
  assert.equal(middles.size, 4);
  await choice(page, "Colours").selectOption("usual");

  // The log-average of all pixels' luminance becomes middle grey.
  const logs = light.map(([r, g, b]) => Math.log2(0.2126 * r + 0.7152 * g + 0.0722 * b));
  const stops = Math.log2(0.18) - logs.reduce((sum, log) => sum + log, 0) / logs.length;
  await page.getByRole("button", { name: "Auto exposure" }).click();
  await until(async () => assert.ok(Math.abs(Number(await page.getByLabel("Exposure in stops").inputValue()) - stops) < 0.011));
  await page.getByRole("button", { name: "Exposure back to 0" }).click();
  await choice(page, "View transform").selectOption("srgb");
  // Of four colours one is above the luminance that is shown white.
  await page.getByRole("img", { name: "Histogram: 25 % above white, 0 % black" }).waitFor();
  await shoot(page, "compare-known");
  await axeClean(page);
});

test("images of other bounces are said to be of other light", async () => {
  const short = await daemon.run(smallJob({ method: { name: "path_tracing", parameters: { indirect_bounces: 1 } } }));
  const page = await openPage(daemon, addressOf({ images: `job:${noisy.id},job:${short.id}` }));
  await settled(page);
  await page.getByText("bounces of indirect light: all in image 1; 1 in image 2").waitFor();
  await page.goto(daemon.url + addressOf({ images: `job:${noisy.id},job:${photons.id}` }));
  await settled(page);
  await until(async () => assert.equal(await page.locator(".compare-images > li a").count(), 2));
  assert.equal(await page.getByText("bounces of indirect light").count(), 0);
  expectNoComplaints(page);
});

test("keys flip, wipe, zoom, move and read; a link brings the very same picture back", async () => {
  const page = await open({});
  const pressed = (label) => until(async () => assert.equal(await page.locator(`.compare-images button[aria-pressed=true]`).innerText(), label));
  await page.keyboard.press("3");
  await pressed("3");
  await page.keyboard.press("[");
  await pressed("2");
  await page.keyboard.press("0");
  await pressed("1");
  await page.keyboard.press("`");
  await pressed("2");
  await page.keyboard.press("9"); // there is none
  await pressed("2");

  await page.keyboard.press("w");
  const slider = page.getByRole("slider", { name: "Wipe" });
  const wiped = (share) => until(async () => assert.equal(await slider.getAttribute("aria-valuenow"), share));
  await wiped("50");
  await page.keyboard.press(".");
  await wiped("52");
  await slider.focus();
  await page.keyboard.press("Shift+ArrowLeft");
  await wiped("42");
  const stage = await page.locator(".compare-stage").boundingBox();
  await page.mouse.move(stage.x + 0.42 * stage.width, stage.y + 30);
  await page.mouse.down();
  await page.mouse.move(stage.x + 0.25 * stage.width, stage.y + 40, { steps: 3 });
  await page.mouse.up();
  await wiped("25");

  await page.locator(".compare-stage").focus();
  await page.keyboard.press("z");
  for (const key of ["+", "+", "+", "ArrowLeft", "Shift+ArrowDown", "x", "t", "e", "k"]) await page.keyboard.press(key);
  await page.keyboard.press("p");
  await page.keyboard.press("ArrowRight");
  await page.keyboard.press("Shift+ArrowUp");
  // Between two keys the address may have followed already: it is waited for until it says what the last one came to.
  const said = await until(async () => {
    const now = query(page);
    assert.deepEqual([now.mode, now.show, now.exposure, now.curve, Number(now.wipe).toFixed(2)], ["wipe", "2", "0.5", "filmic", "0.25"]);
    assert.deepEqual([now.zoom, now.error], ["4", "signed"]);
    assert.match(now.crops ?? "", /^\d+,\d+,48,48$/);
    assert.equal(now.pixel, await page.evaluate(() => ["column", "row"].map((name) => document.querySelector(`[aria-label="Pixel's ${name}"]`).value).join()));
    return now;
  });
  await settled(page);
  const { width, height } = stage;
  const before = await painted(page, Math.floor(width) - 2, Math.floor(height) - 2);
  await page.getByRole("button", { name: "Copy link" }).click();
  await page.getByText("A link to this view is copied").waitFor();
  const link = await page.evaluate(() => navigator.clipboard.readText());
  const again = await openPage(daemon, link.slice(daemon.url.length));
  await settled(again);
  await until(async () => assert.ok(before.equals(await painted(again, Math.floor(width) - 2, Math.floor(height) - 2)), "the linked view differs"));
  await until(async () => assert.equal(await again.getByLabel("Pixel's column").inputValue(), said.pixel.split(",")[0]));

  await page.keyboard.press("Escape");
  await page.keyboard.press("?");
  await page.getByRole("dialog", { name: "Keys" }).getByText("make the image shown the reference").waitFor();
  await page.keyboard.press("Escape");
  expectNoComplaints(page);
  expectNoComplaints(again);
});

test("a pixel's values are the daemon's, under the pointer and by keys", async () => {
  const page = await open({ zoom: "8", at: "24,24", show: "2" });
  const pixels = await floats(`/v1/jobs/${noisy.id}/pixels`);
  const stage = await page.locator(".compare-stage > canvas").boundingBox();
  const [x, y] = [21, 30];
  await page.mouse.move(stage.x + Math.round(stage.width / 2 - 24 * 8) + 8 * x + 4, stage.y + Math.round(stage.height / 2 - 24 * 8) + 8 * y + 4);
  const row = page.getByRole("region", { name: "Values of the pixel" }).getByRole("row").nth(2);
  const values = async () => (await row.locator("td").allInnerTexts()).map((text) => Number(text.replace("−", "-")));
  const near = async (px, py) => {
    await page.waitForFunction(([wx, wy]) => document.querySelector("[aria-label=\"Pixel's column\"]").value === String(wx) && document.querySelector("[aria-label=\"Pixel's row\"]").value === String(wy), [px, py]);
    const wanted = pixels.subarray(3 * (py * kSide + px), 3 * (py * kSide + px) + 3);
    await until(async () => {
      const [red, green, blue, luminance] = await values();
      [red, green, blue].forEach((value, k) => assert.ok(Math.abs(value - wanted[k]) <= 1e-3 * Math.abs(wanted[k]) + 1e-7, `${value} for ${wanted[k]}`));
      assert.ok(Math.abs(luminance - (0.2126 * wanted[0] + 0.7152 * wanted[1] + 0.0722 * wanted[2])) < 1e-3 * luminance + 1e-7);
    });
  };
  await near(x, y);
  await page.mouse.down();
  await page.mouse.up();
  await page.mouse.move(2, 2);
  await near(x, y);
  await page.keyboard.press("p");
  await page.keyboard.press("ArrowLeft");
  await page.keyboard.press("ArrowDown");
  await near(x - 1, y + 1);
  await addressSays(page, "pixel", `${x - 1},${y + 1}`);
  expectNoComplaints(page);
});

test("crops are drawn by hand, enlarged by whole pixels, and saved", async () => {
  const page = await open({ zoom: "8", at: "24,24", show: "2", cropzoom: "4" });
  await page.getByRole("button", { name: "Draw one" }).click();
  await page.locator(".compare-stage").scrollIntoViewIfNeeded();
  const stage = await page.locator(".compare-stage > canvas").boundingBox();
  const place = (px, py) => [stage.x + Math.round(stage.width / 2 - 24 * 8) + 8 * px + 4, stage.y + Math.round(stage.height / 2 - 24 * 8) + 8 * py + 4];
  await page.mouse.move(...place(10, 12));
  await page.mouse.down();
  await page.mouse.move(...place(19, 17), { steps: 3 });
  await page.mouse.up();
  await addressSays(page, "crops", "10,12,10,6");
  await settled(page);
  const strip = page.getByRole("region", { name: "Crop A of all images" });
  await until(async () => assert.equal(await strip.locator("canvas").count(), 3));
  const preview = await pictureAt(page, `/v1/jobs/${noisy.id}/preview.png`);
  // A crop is drawn a moment after it is there.
  await until(async () => {
    const crop = Buffer.from(await strip.locator("canvas").nth(1).evaluate((canvas) => [...canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data]));
    assert.equal(crop.length, 4 * 40 * 24);
    for (let y = 0; y < 24; ++y)
      for (let x = 0; x < 40; ++x)
        for (let k = 0; k < 3; ++k) {
          const wanted = preview[4 * ((12 + Math.floor(y / 4)) * kSide + 10 + Math.floor(x / 4)) + k];
          assert.ok(Math.abs(crop[4 * (40 * y + x) + k] - wanted) <= 1, `${x}, ${y}`);
        }
  });
  await page.getByLabel("Crop A: width").fill("20");
  await addressSays(page, "crops", "10,12,20,6");
  const saved = async (button) => {
    const [download] = await Promise.all([page.waitForEvent("download"), page.getByRole("button", { name: button }).click()]);
    const png = readFileSync(await download.path());
    assert.equal(png.subarray(1, 4).toString(), "PNG");
    return { name: download.suggestedFilename(), width: png.readUInt32BE(16), height: png.readUInt32BE(20) };
  };
  const strips = await saved("Save as PNG");
  assert.equal(strips.name, "photond-crops.png");
  assert.ok(strips.width > 3 * 80 && strips.height > 24);
  const view = await saved("Save view as PNG");
  assert.deepEqual([view.width, view.height], [Math.round(stage.width), Math.round(stage.height)]);
  await page.getByRole("button", { name: "Remove crop A" }).click();
  await strip.waitFor({ state: "detached" });
  expectNoComplaints(page);
});

test("images of other sizes and layers, faulty links and missing jobs say what is the matter", async () => {
  const wide = await daemon.run(smallJob({ image: { width: 64, height: 32 }, stop: { passes: 1 } }));
  const page = await openPage(daemon, `/compare?images=job:${reference.id},job:${wide.id},job:J4000&error=relative&mode=grid&show=7&curve=sepia`, { expected: /404/ });
  await settled(page);
  await page.getByText("The images are of different sizes.").waitFor();
  await page.getByText("no error map: the reference has 48 × 48 pixels, this image 64 × 32").waitFor();
  await page.locator(".compare-note", { hasText: "J4000" }).waitFor();
  await until(async () => assert.deepEqual(await page.locator(".notice[role=alert] li").allInnerTexts(), ["show=7: there are images 1 to 3", "curve=sepia: must be one of srgb, filmic, aces, agx, neutral, linear"]));
  await axeClean(page);
  await page.getByRole("button", { name: /^Take J4000/ }).click();
  await choice(page, "Layer").selectOption({ label: "normal (1 of 2)" });
  await page.locator(".compare-note", { hasText: "has no layer normal" }).waitFor();
  expectNoComplaints(page);
});

test("images are added from the newest jobs and by id", async () => {
  const page = await openPage(daemon, `/compare?images=${all[2]}`);
  await settled(page);
  await page.getByRole("button", { name: `Add the reference ${reference.id}` }).click();
  await addressSays(page, "images", `${all[2]},${all[0]}`);
  await addressSays(page, "reference", all[0]);
  await page.getByRole("button", { name: /^Take .*photon/ }).click();
  await page.getByRole("button", { name: "Add images …" }).first().click();
  const dialog = page.getByRole("dialog", { name: "Add images" });
  await dialog.getByLabel("Of the newest jobs").fill("photon 48");
  await until(async () => assert.equal(await dialog.getByRole("checkbox").count(), 1));
  await dialog.getByRole("checkbox").check();
  await page.waitForFunction(() => [...document.querySelectorAll("dialog img")].every((image) => image.complete));
  await shoot(page, "compare-picker");
  await axeClean(page);
  await dialog.getByRole("button", { name: "Add 1" }).click();
  await addressSays(page, "images", `${all[0]},${all[2]}`);
  await page.getByRole("button", { name: "Add images …" }).first().click();
  await dialog.getByLabel("By id").fill(noisy.id);
  await page.keyboard.press("Enter");
  await addressSays(page, "images", `${all[0]},${all[2]},${all[1]}`);
  await settled(page);
  expectNoComplaints(page);
});

test("a job that runs is followed", async () => {
  const running = await daemon.submit(smallJob({ stop: { passes: 1_000_000 } }));
  const page = await openPage(daemon, `/compare?images=job:${running.id},${all[0]}&zoom=1&at=24,24`);
  try {
    await settled(page);
    await page.waitForFunction(() => !document.querySelector(".compare-note"));
    await settled(page);
    const first = await painted(page, kSide);
    await until(async () => assert.ok(!first.equals(await painted(page, kSide)), "the picture stays the same"));
  } finally {
    await daemon.json("DELETE", `/v1/jobs/${running.id}`);
  }
  await page.locator(".compare-images", { hasText: "running" }).waitFor({ state: "detached" });
  expectNoComplaints(page);
});

test("every layout is clean by axe in both themes, on a desk and on a phone", async () => {
  const page = await open({ mode: "grid", error: "relative", crops: "10,10,16,16", pixel: "20,20" });
  await page.getByRole("cell", { name: /0\.\d+ ★/ }).first().waitFor();
  await shoot(page, "compare-grid", { fullPage: true });
  await axeClean(page);
  await page.getByRole("button", { name: "Wipe", exact: true }).click();
  await choice(page, "Error").selectOption("signed");
  await page.keyboard.press("2");
  await settled(page);
  await shoot(page, "compare-wipe");
  await axeClean(page);
  await page.getByRole("button", { name: "One", exact: true }).click();
  await choice(page, "Layer").selectOption("normal");
  await settled(page);
  await axeClean(page);
  await page.setViewportSize({ width: 390, height: 844 });
  await settled(page);
  await fitsItsWidth(page);
  await shoot(page, "compare-phone", { fullPage: true });
  await axeClean(page);
});

test("without WebGL2 the room says so", async () => {
  const page = await openPage(daemon, "/compare");
  await page.addInitScript(() => {
    const get = HTMLCanvasElement.prototype.getContext;
    HTMLCanvasElement.prototype.getContext = function (kind, ...more) {
      return kind === "webgl2" ? null : get.call(this, kind, ...more);
    };
  });
  await page.goto(daemon.url + addressOf({}));
  await page.getByRole("alert").filter({ hasText: "no WebGL2" }).waitFor();
  await axeClean(page);
});

test("a graphics unit that is taken away comes back with the pictures", async () => {
  const page = await openPage(daemon, "/compare");
  await page.addInitScript(() => {
    const get = HTMLCanvasElement.prototype.getContext;
    HTMLCanvasElement.prototype.getContext = function (kind, ...more) {
      const context = get.call(this, kind, ...more);
      if (kind === "webgl2") window.taken ??= context.getExtension("WEBGL_lose_context");
      return context;
    };
  });
  await page.goto(daemon.url + addressOf({ ...oneToOne, show: "2" }));
  await settled(page);
  await page.evaluate(() => window.taken.loseContext());
  const lost = page.getByText("The graphics unit has been taken away from the page.");
  await lost.waitFor();
  await page.keyboard.press("x"); // a picture that is not developed yet
  await page.evaluate(() => window.taken.restoreContext());
  await lost.waitFor({ state: "detached" });
  await settled(page);
  await until(async () => assert.ok(differences(await painted(page, kSide), await pictureAt(page, `/v1/jobs/${noisy.id}/preview.png?exposure=0.5`)).greatest <= 1));
  expectNoComplaints(page);
});

// Frame times are printed, not judged: they are the machine's and its load's as much as the page's. Who wants to know them
// asks for more frames than show that all of it works.
const kFrames = Number(process.env.PHOTOND_FRAMES ?? 8);
test("flip, wipe and pan of a 1920 x 1080 pair: frame times", async (context) => {
  const size = { image: { width: 1920, height: 1080 }, method: { name: "path_tracing", parameters: { indirect_bounces: 0 } }, stop: { passes: 1 } };
  const pair = [await daemon.run(smallJob(size)), await daemon.run(smallJob({ ...size, seed: 7 }))];
  const page = await openPage(daemon, `/compare?images=${pair.map((job) => `job:${job.id}`).join(",")}&mode=wipe`, { width: 1920, height: 1080 });
  await settled(page);
  const stage = await page.locator(".compare-stage").boundingBox();
  const middle = [stage.x + stage.width / 2, stage.y + stage.height / 2];
  for (const zoom of ["Fit", "1:1"]) {
    await page.getByRole("button", { name: zoom, exact: true }).click();
    await settled(page);
    for (const what of ["flip", "wipe", "pan"]) {
      const times = await page.evaluate(
        async ([kind, cx, cy, frames]) => {
          const stage = document.querySelector(".compare-stage");
          const wipe = document.querySelector(".compare-wipe");
          const capture = Element.prototype.setPointerCapture;
          Element.prototype.setPointerCapture = () => {}; // no pointer of the browser's own is down
          const send = (type, x, y) => (kind === "wipe" ? wipe : stage).dispatchEvent(new PointerEvent(type, { bubbles: true, clientX: x, clientY: y, pointerId: 1, button: 0, buttons: 1 }));
          if (kind !== "flip") send("pointerdown", cx, cy);
          const found = [];
          let last = await new Promise(requestAnimationFrame);
          for (let i = 0; i < frames; ++i) {
            if (kind === "flip") document.dispatchEvent(new KeyboardEvent("keydown", { key: String(1 + (i % 2)), bubbles: true }));
            else send("pointermove", cx + 300 * Math.sin(i / 8), cy + 100 * Math.sin(i / 5));
            const now = await new Promise(requestAnimationFrame);
            found.push(now - last);
            last = now;
          }
          if (kind !== "flip") send("pointerup", cx, cy);
          Element.prototype.setPointerCapture = capture;
          return found.sort((a, b) => a - b);
        },
        [what, ...middle, kFrames],
      );
      const mean = times.reduce((sum, time) => sum + time, 0) / times.length;
      context.diagnostic(`${zoom}, ${what}: median ${times[Math.floor(0.5 * kFrames)].toFixed(1)} ms, 95 % within ${times[Math.floor(0.95 * kFrames)].toFixed(1)} ms, ${(1000 / mean).toFixed(1)} frames a second`);
    }
  }
  expectNoComplaints(page);
});
