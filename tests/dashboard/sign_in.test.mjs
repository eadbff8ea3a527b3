// A daemon that wants a token: what a wrong one is answered, who knows a right one, and how it is forgotten.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { mkdtempSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";

import { after, axeClean, bin, fitsItsWidth, kTelephone, openPage, shoot, startDaemon, test, until } from "./support.mjs";

const folder = mkdtempSync(join(tmpdir(), "photond-tokens-"));
after(() => rmSync(folder, { recursive: true, force: true }));
const made = execFileSync(join(bin, "photond"), ["--new-token", "somebody:write"], { encoding: "utf8" });
const [, line] = /line:\s*(\S.*)/.exec(made);
const [, token] = /token:\s*(\S+)/.exec(made);
writeFileSync(join(folder, "tokens"), `${line}\n`, { mode: 0o600 });
const daemon = await startDaemon({ arguments: ["--tokens", join(folder, "tokens")] });

const kRefused = /status of 401/;
const field = (page) => page.getByLabel("Token", { exact: true });
const shown = (page) => page.getByText("0 running, 0 waiting").waitFor();
async function another(page) {
  const tab = await page.context().newPage();
  await tab.goto(daemon.url);
  return tab;
}

test("a wrong token is said to be, a right one is known to all tabs until the last is closed", async () => {
  const page = await openPage(daemon, "/", { expected: kRefused });
  await field(page).fill("not-the-one");
  await page.getByRole("button", { name: "Sign in" }).click();
  await page.getByRole("alert").getByText("The daemon does not know this token.").waitFor();
  await axeClean(page);
  await shoot(page, "sign-in-refused");
  await field(page).fill(token);
  await page.getByRole("button", { name: "Sign in" }).click();
  await shown(page);
  const second = await another(page);
  await shown(second);
  assert.equal(await second.evaluate(() => JSON.stringify(localStorage)).then((kept) => kept.includes("photond.token")), false, "it is not on disk");

  await second.getByRole("button", { name: "Sign out" }).click();
  for (const tab of [page, second]) await field(tab).waitFor();
  const third = await another(page);
  await field(third).waitFor();
});

test("a token that is to stay does, and is forgotten when one signs out", async () => {
  const page = await openPage(daemon, "/", { expected: kRefused });
  await field(page).fill(token);
  await page.getByLabel(/Keep me signed in/).check();
  await page.getByRole("button", { name: "Sign in" }).click();
  await shown(page);
  const second = await another(page);
  await page.close(); // a fresh tab has no session of an earlier one
  await shown(second);
  assert.equal(await second.evaluate(() => localStorage.getItem("photond.token")), token);
  await second.getByRole("button", { name: "Sign out" }).click();
  await field(second).waitFor();
  await until(async () => assert.equal(await second.evaluate(() => localStorage.getItem("photond.token")), null));
});

test("on a telephone all that the bar has is within reach, and it leaves the room its place", async () => {
  const page = await openPage(daemon, "/jobs", { ...kTelephone, expected: kRefused });
  await field(page).fill(token);
  await page.getByRole("button", { name: "Sign in" }).click();
  await shown(page);
  await fitsItsWidth(page);
  const bar = page.locator(".bar");
  assert.ok((await bar.boundingBox()).height <= 100);
  await page.getByRole("button", { name: "Menu" }).click();
  for (const place of await bar.locator("a, button").all()) {
    const { x, width, height } = await place.boundingBox();
    assert.ok(x >= 0 && x + width <= kTelephone.width, await place.innerText());
    assert.ok(width >= 32 && height >= 32, `${await place.innerText()} is ${width} by ${height}`);
  }
  await axeClean(page);
  await shoot(page, "telephone-menu");
  await page.getByRole("link", { name: "Scenes", exact: true }).click();
  await page.waitForURL("**/scenes");
  await page.getByRole("link", { name: "Sequences" }).waitFor({ state: "hidden" });
  await page.getByRole("button", { name: "Menu" }).click();
  await page.keyboard.press("Escape");
  await page.getByRole("link", { name: "Sequences" }).waitFor({ state: "hidden" });
  await page.getByRole("button", { name: "Menu" }).click();
  await page.getByRole("button", { name: "Sign out" }).click();
  await field(page).waitFor();
});
