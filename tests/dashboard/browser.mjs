// The browser that looks at a daemon's pages: Debian's Chromium, one for all files of tests. It is the headless shell: the whole
// browser without a window takes twice as much for the same pages, most of it for its own.

import assert from "node:assert/strict";
import { mkdirSync, readFileSync } from "node:fs";
import { createRequire } from "node:module";
import { join } from "node:path";

import { chromium } from "playwright-core";

import { suite, until } from "./suite.mjs";

/** Where pictures are kept; nowhere unless somebody wants them. */
const pictures = process.env.PHOTOND_SCREENSHOTS;
const axeSource = readFileSync(createRequire(import.meta.url).resolve("axe-core/axe.min.js"), "utf8");

const kChromiumArguments = [
  "--no-sandbox",
  "--disable-gpu",
  "--use-gl=angle",
  "--use-angle=swiftshader",
  "--enable-unsafe-swiftshader",
  "--disable-quic",
  "--disable-background-networking",
  "--disable-component-update",
  "--disable-sync",
  "--no-first-run",
];

let started = null;

/** The program's one browser. When it dies, the file that runs fails, and the next has another one. */
function browser() {
  started ??= chromium.launch({ executablePath: "/usr/bin/chromium-headless-shell", args: kChromiumArguments, timeout: 0 }).then((found) => {
    found.once("disconnected", () => {
      started = null;
      suite()?.lifeline.lose(new Error("the browser died"));
    });
    return found;
  });
  return started;
}

export async function closeBrowser() {
  const found = await started;
  await found?.close();
}

/** Options of openPage(). */
export const kTelephone = { width: 390, height: 844, finger: true };

const WAITING_PICTURE = /status of 503.*\/scenes\/[^/]+\/(thumbnail|preview)\.png/;

/**
 * A page of the dashboard, closed with the test that opens it, else with the file. What the browser complains of (an
 * exception, a console error, a violated content security policy, a file that is not there) is in page.complaints, and
 * axeClean() and expectNoComplaints() fail by it. `expected`: a pattern of complaints that belong to the test, such as of
 * requests that are to be refused. A scene's picture that waits for a running job (503, which the page asks for again)
 * belongs to every test: the console names each. `finger`: of a device on which a finger points and nothing hovers.
 */
export async function openPage(daemon, path = "/", { width = 1440, height = 900, theme = "light", expected = null, finger = false } = {}) {
  const { lifeline, ofCase, closing } = suite();
  const context = await (await browser()).newContext({ viewport: { width, height }, colorScheme: theme, reducedMotion: "reduce", acceptDownloads: true, hasTouch: finger, isMobile: finger });
  // A page that is not looked at any more would go on drawing.
  (ofCase ?? closing).push(() => context.close());
  context.setDefaultTimeout(0); // waits end by what they wait for, or by a death
  context.on("page", (opened) => opened.on("crash", () => lifeline.lose(new Error(`the page crashed: ${opened.url()}`))));
  await context.grantPermissions(["clipboard-read", "clipboard-write"], { origin: daemon.url });
  const page = await context.newPage();
  page.complaints = [];
  const complain = (text) => {
    if (!expected?.test(text) && !WAITING_PICTURE.test(text)) page.complaints.push(text);
  };
  page.on("pageerror", (error) => complain(`exception: ${error.stack ?? error.message}`));
  page.on("console", (message) => {
    if (message.type() === "error") complain(`console: ${message.text()} (${message.location().url})`);
  });
  await page.goto(daemon.url + path);
  return page;
}

/** Waits until nothing of the page is wider than its window. */
export async function fitsItsWidth(page) {
  const { width } = page.viewportSize();
  await until(async () => {
    const wide = await page.evaluate(() => document.documentElement.scrollWidth);
    assert.ok(wide <= width, `the page scrolls sideways: ${wide} pixels in ${width}`);
  });
}

/** Fails by whatever the browser has complained of on this page. */
export function expectNoComplaints(page) {
  assert.deepEqual(page.complaints, []);
}

const kRules = ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "best-practice"];

/** Runs `look` in the light and in the dark. */
async function inBothThemes(page, look) {
  for (const theme of ["light", "dark"]) {
    await page.emulateMedia({ colorScheme: theme, reducedMotion: "reduce" });
    await page.waitForFunction((wanted) => document.documentElement.dataset.theme === wanted, theme);
    await look(theme);
  }
  await page.emulateMedia({ colorScheme: "light", reducedMotion: "reduce" });
}

/** Keeps pictures of the page, light and dark, to be looked at. */
export async function shoot(page, name, options = {}) {
  if (!pictures) return;
  mkdirSync(pictures, { recursive: true });
  await inBothThemes(page, (theme) => page.screenshot({ path: join(pictures, `${name}-${theme}.png`), ...options }));
}

/**
 * Fails by every rule of WCAG 2 A and AA that axe sees broken, and by complaints of the browser. Themes differ in colour
 * alone: the other one is held to the rule on contrast.
 */
export async function axeClean(page, { exclude = [] } = {}) {
  await inBothThemes(page, async (theme) => {
    // By the debugger, not as a script of the page: its policy would not have it.
    await page.evaluate(`if (!window.axe) { ${axeSource} }`);
    const found = await page.evaluate(
      ({ without, rules }) =>
        window.axe.run(without.length ? { exclude: without } : document, { runOnly: rules, resultTypes: ["violations"], selectors: false, preload: false }).then((result) =>
          result.violations.map((rule) => `${rule.id}: ${rule.help}\n${rule.nodes.slice(0, 4).map((node) => `    ${node.html.slice(0, 160)}\n      ${node.failureSummary.replaceAll("\n", " ")}`).join("\n")}`),
        ),
      { without: exclude, rules: theme === "light" ? kRules : ["color-contrast"] },
    );
    assert.deepEqual(found, [], `${page.url()} in the ${theme} theme`);
  });
  expectNoComplaints(page);
}
