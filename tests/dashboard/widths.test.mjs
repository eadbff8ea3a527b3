// Every page at the width of a desk and of a telephone: nothing is wider than the window, no column is cut off, and a finger
// hits what it is to hit.

import assert from "node:assert/strict";

import { expectNoComplaints, fitsItsWidth, kTelephone, openPage, shoot, smallJob, startDaemon, test, until } from "./support.mjs";
import { tinyGlb } from "./tiny_glb.mjs";

const daemon = await startDaemon();
const reference = await daemon.run(smallJob({ stop: { passes: 16 }, labels: { study: "a-label-that-is-rather-long-for-a-column" } }));
const job = await daemon.run(smallJob({ reference: `job:${reference.id}`, stop: { passes: 8 }, layers: ["normal", "depth"] }));
const uploaded = await daemon.upload("two-squares", tinyGlb());
await daemon.run(smallJob({ scene: uploaded.id }));
const sequence = await daemon.json("POST", "/v1/sequences", { scene: "moving/teleport", image: { width: 32, height: 32 }, method: { name: "stochastic_progressive_photon_mapping" }, stop: { passes: 1 }, to: 0.25, fps: 4 });
const study = await daemon.json("POST", "/v1/comparisons", {
  scene: "cornell-box",
  image: { width: 32, height: 32 },
  reference: { method: { name: "path_tracing" }, stop: { passes: 32 } },
  entries: [
    { label: "paths", method: { name: "path_tracing" } },
    { label: "paths again", method: { name: "path_tracing" } }, // at the same place of every figure
    { label: "stochastic progressive photon mapping, few photons", method: { name: "stochastic_progressive_photon_mapping", parameters: { photons: 1000 } } },
  ],
  stop: { passes: 4 },
});
await daemon.succeeds(`/v1/comparisons/${study.id}`);

/** An address, and what is there once the page shows what it is for. */
const kPages = {
  now: ["/", ".now-recent-job"],
  jobs: ["/jobs", ".jobs-row .jobs-method >> text=path tracing"],
  job: [`/jobs/${job.id}`, ".job-picture img"],
  render: ["/render", ".render-estimate"],
  compare: [`/compare?images=job:${reference.id},job:${job.id}`, ".compare-histogram"],
  "compare-start": ["/compare", ".compare-jobs img"],
  studies: ["/studies", `a[href^="/studies/${study.id}"]`],
  study: [`/studies/${study.id}`, ".scroll-x table"],
  "new-study": ["/studies/new", ".new-study-entry"],
  "hard-cases": ["/studies/hard-cases", "h1"],
  sequences: ["/sequences", "td.records-what"],
  sequence: [`/sequences/${sequence.id}`, ".sequence-frame img"],
  scenes: ["/scenes", ".scenes-card img"],
  scene: ["/scenes/cornell-box", ".scene-picture img"],
  api: ["/api", ".api-operation"],
};

/**
 * Elements that reach beyond the window, and boxes that hide a part of their text, with an ellipsis or without, and neither
 * scroll to it nor say it in a title. What only screen readers read is no column cut off.
 */
const kCut = () => {
  const said = (element) => `${element.tagName.toLowerCase()}.${[...element.classList].join(".")} “${element.textContent.trim().slice(0, 40)}”`;
  const found = [];
  const width = document.documentElement.clientWidth;
  const inScroller = (element) => {
    for (let at = element.parentElement; at && at !== document.body; at = at.parentElement) if (["auto", "scroll"].includes(getComputedStyle(at).overflowX)) return true;
    return false;
  };
  for (const element of document.querySelectorAll("body *")) {
    const style = getComputedStyle(element);
    const box = element.getBoundingClientRect();
    if (box.width < 2 || box.height < 2 || style.visibility === "hidden" || element.closest(".visually-hidden, .skip, svg, canvas, option, [aria-hidden=true]")) continue;
    if (box.right > width + 1 && !inScroller(element)) found.push(`beyond the window by ${Math.round(box.right - width)}: ${said(element)}`);
    const hides = ["hidden", "clip"].includes(style.overflowX) && !element.matches(".compare-stage, .scene-picture, .compare-pane, input, img, [title]") && !element.querySelector("[title]");
    if (hides && element.scrollWidth > element.clientWidth + 1) found.push(`cut by ${element.scrollWidth - element.clientWidth}: ${said(element)}`);
    if (hides && style.webkitLineClamp !== "none" && element.scrollHeight > element.clientHeight + 1) found.push(`cut below: ${said(element)}`);
    // Places that scroll sideways on a telephone are for tables and code, not for what leads elsewhere.
    if (element.tagName === "NAV" && element.scrollWidth > element.clientWidth + 1) found.push(`links that are out of sight: ${said(element)}`);
  }
  const wide = document.documentElement.scrollWidth - width;
  return wide > 0 ? [`the page scrolls sideways by ${wide}`, ...found] : found;
};

/** What one taps and is less than 32 pixels wide or high. A link within a text is as high as its line. */
const kSmall = () =>
  [...document.querySelectorAll("button, .button, select, summary, nav a, td > a:only-child, .room-actions > a, .jobs-box, .jobs-job a, .job-compare")]
    .map((element) => ({ element, box: element.getBoundingClientRect() }))
    .filter(({ element, box }) => box.width > 0 && !element.closest(".visually-hidden") && (box.width < 32 || box.height < 32))
    .map(({ element, box }) => `${box.width} by ${box.height}: ${element.tagName} ${element.className} ${element.textContent.trim().slice(0, 30)}`);

/** Two windows, each of which shows one page after the other. */
const windows = { desk: await openPage(daemon, "/", { width: 1440, height: 900 }), telephone: await openPage(daemon, "/", kTelephone) };

/** The window once it shows what the page is for. */
async function show(place, name) {
  const page = windows[place];
  const [path, shown] = kPages[name];
  await page.goto(daemon.url + path);
  await page.locator(shown).first().waitFor();
  return page;
}

for (const name of Object.keys(kPages))
  test(`${name} fits a desk and a telephone`, async () => {
    for (const place of Object.keys(windows)) {
      const page = await show(place, name);
      await until(async () => assert.deepEqual(await page.evaluate(kCut), [], `${page.url()} on a ${place}`));
      if (place === "telephone") assert.deepEqual(await page.evaluate(kSmall), [], page.url());
      await shoot(page, `width-${name}-${place}`, { fullPage: true });
      expectNoComplaints(page);
    }
  });

test("a table too wide for a telephone is scrolled within itself, by keys too", async () => {
  const page = await show("telephone", "study");
  const scrollers = page.locator(".scroll-x");
  for (const scroller of await scrollers.all()) {
    if (!(await scroller.evaluate((element) => element.scrollWidth > element.clientWidth + 1))) continue;
    assert.equal(await scroller.evaluate((element) => element.tabIndex), 0, await scroller.innerText());
  }
  expectNoComplaints(page);
});

test("lists are cards on a telephone, with nothing of them out of sight", async () => {
  for (const name of ["studies", "sequences"]) {
    const page = await show("telephone", name);
    await fitsItsWidth(page);
    for (const cell of await page.locator(".records td").all()) {
      const { x, width } = await cell.boundingBox();
      assert.ok(x >= 0 && x + width <= kTelephone.width, `${name}: ${await cell.innerText()}`);
    }
    const { width } = await page.locator("td.records-what").first().boundingBox();
    assert.ok(width > 300, `what it is has ${width} pixels`);
    expectNoComplaints(page);
  }
});

test("the images to add are named by their scenes, each within its card", async () => {
  const page = await show("telephone", "compare-start");
  await page.getByRole("button", { name: "Choose images …" }).click();
  const dialog = page.getByRole("dialog", { name: "Add images" });
  await dialog.getByText("two-squares, 48 × 48").waitFor();
  assert.equal(await dialog.getByText(uploaded.id).count(), 0);
  await dialog.getByLabel("Of the newest jobs").fill("two-squares");
  await until(async () => assert.equal(await dialog.locator("li").count(), 1));
  for (const card of await dialog.locator("li").all()) assert.ok(await card.evaluate((element) => element.scrollWidth <= element.clientWidth));
  await shoot(page, "telephone-add-images");
  expectNoComplaints(page);
});

test("the pictures to compare come first on a telephone", async () => {
  const page = await show("telephone", "compare");
  const { y } = await page.locator(".compare-stage").boundingBox();
  assert.ok(y < 350, `they begin at ${y}`);
  expectNoComplaints(page);
});

test("no name in a figure lies over another, and a table says that there is more of it", async () => {
  const page = await show("telephone", "study");
  await page.getByRole("img", { name: "relative_mse at the end against peak memory", exact: true }).locator("svg").waitFor();
  const covered = await page.evaluate(() => {
    const found = [];
    for (const figure of document.querySelectorAll(".study-plot-holder > svg")) {
      const texts = [...figure.querySelectorAll("text")].map((text) => ({ text: text.textContent, box: text.getBoundingClientRect() }));
      for (const [i, { text, box }] of texts.entries())
        for (const other of texts.slice(i + 1))
          // A font's box is higher than its letters.
          if (box.left < other.box.right && other.box.left < box.right && box.top + 4 < other.box.bottom && other.box.top + 4 < box.bottom) found.push(`${text} / ${other.text}`);
    }
    return found;
  });
  assert.deepEqual(covered, []);
  const scrolled = await page.locator(".scroll-x").evaluateAll((all) => all.filter((one) => one.scrollWidth > one.clientWidth + 1).map((one) => getComputedStyle(one).backgroundAttachment));
  assert.ok(scrolled.length > 0);
  for (const attachment of scrolled) assert.equal(attachment, "local, local, scroll, scroll");
  expectNoComplaints(page);
});

test("who points with a finger is told what a finger does", async () => {
  const kMouse = /Shift to pan|Ctrl\+Enter|with the mouse|Drop a|dropped anywhere|or drop /;
  for (const [name, finger] of [["scene", "two fingers pan it"], ["scenes", "A scene is a"], ["render", "with a finger"], ["compare-start", "Two to nine images"], ["hard-cases", "Scenes whose answer is known"], ["now", "photond"]]) {
    const page = await show("telephone", name);
    await page.getByText(finger).first().waitFor();
    assert.doesNotMatch(await page.locator("body").innerText(), kMouse, name);
    const desk = await show("desk", name);
    assert.doesNotMatch(await desk.locator("main").innerText(), /finger/, name);
  }
});

test("a box of the list of jobs is picked anywhere in its cell", async () => {
  const page = await show("telephone", "jobs");
  const cell = page.locator(".jobs-space .jobs-pick").first();
  const { width, height } = await cell.boundingBox();
  await cell.click({ position: { x: width / 2, y: height - 6 } });
  await page.getByText("1 job selected").waitFor();
  await cell.click({ position: { x: width / 2, y: height / 2 } });
  await page.getByText("1 job selected").waitFor({ state: "detached" });
  expectNoComplaints(page);
});

test("a job's log begins with a whole line, and its figures are in one line each", async () => {
  const page = await show("telephone", "job");
  const log = page.locator(".job-log");
  await log.getByText("succeeded").waitFor();
  const { top, line, room, whole } = await log.evaluate((element) => ({
    top: element.scrollTop,
    line: parseFloat(getComputedStyle(element).lineHeight),
    room: element.clientHeight,
    whole: element.scrollHeight,
  }));
  assert.ok(whole > room, "the log is longer than its box");
  assert.ok(Math.abs(top - (whole - room)) < 2, "its end is shown");
  assert.equal(Math.round(top) % line, 0);
  for (const figure of await page.locator(".job-table td.number").all()) assert.equal(await figure.evaluate((element) => getComputedStyle(element).whiteSpace), "nowrap");
  expectNoComplaints(page);
});

test("on a telephone no scene to choose covers another, and a subject of the API stands apart from its count", async () => {
  const page = await show("telephone", "new-study");
  await page.locator(".new-study-scene").nth(8).waitFor(); // more than its box has room for
  for (const scene of await page.locator(".new-study-scene").all()) assert.ok(await scene.evaluate((tile) => tile.scrollHeight <= tile.clientHeight + 1), await scene.innerText());
  await page.goto(daemon.url + kPages.api[0]);
  const subject = page.getByRole("navigation", { name: "Subjects" }).locator("a").first();
  const [name, count] = await subject.evaluate((link) => {
    const text = document.createRange();
    text.selectNodeContents(link.firstChild);
    return [text.getBoundingClientRect().right, link.lastElementChild.getBoundingClientRect().left];
  });
  assert.ok(count > name + 2, `${name} to ${count}`);
  expectNoComplaints(page);
});
