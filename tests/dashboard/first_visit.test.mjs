// The newcomer's walk: from the start page, without documentation, the Cornell box by two methods, and which is better.

import assert from "node:assert/strict";

import { axeClean, expectNoComplaints, openPage, shoot, startDaemon, test, until } from "./support.mjs";

const daemon = await startDaemon();

test("a newcomer compares two methods on the Cornell box and is told which is better", async () => {
  const page = await openPage(daemon);
  await page.getByRole("link", { name: /Compare two methods/ }).click();

  await page.getByRole("heading", { level: 1, name: "New comparison" }).waitFor();
  await page.locator(".new-study-entry").nth(1).waitFor();
  await until(async () => assert.deepEqual(await page.locator(".new-study-entry h3").allInnerTexts(), ["1. path tracing", "2. photon mapping"]));
  await until(async () => assert.equal(await page.locator('input[name="scene"]:checked').inputValue(), "cornell-box"));
  await page.locator(".new-study-total").waitFor();
  await shoot(page, "first-visit-form");
  // All is filled in for one press. The test has less time than a person: it asks for smaller pictures, sooner, and for a
  // reference of fewer passes.
  await page.getByLabel("Width").fill("64");
  await page.getByLabel("Height").fill("64");
  await page.getByRole("spinbutton", { name: /^Time/ }).fill("0.3");
  await page.getByRole("region", { name: "Reference" }).getByLabel("Passes").fill("128");
  await page.getByRole("button", { name: "Compare", exact: true }).click();

  // No reload, no other page: what comes of it comes here.
  await page.waitForURL(/\/studies\/C\d+/);
  const verdict = page.getByRole("region", { name: "Verdict" });
  // Over when nothing is "so far" any more.
  const id = new URL(page.url()).pathname.split("/").at(-1);
  const study = await daemon.succeeds(`/v1/comparisons/${id}`);
  await verdict.getByRole("heading", { name: /^(?!Nothing|No verdict)(?!.*, so far\.$)/ }).waitFor();
  await verdict.getByText(/^(Path tracing|Photon mapping|Too close to call at).*relative_mse/i).first().waitFor();
  await shoot(page, "first-visit-verdict", { fullPage: true });
  await axeClean(page);

  // The words are the figures': what the daemon's own table says.
  const { text } = study.headlines.find(({ metric }) => metric === "relative_mse");
  await until(async () => assert.equal((await verdict.getByRole("heading").innerText()).trim(), `${text}.`));

  // Back at the start page, it has become what was found.
  await page.getByRole("link", { name: "Now", exact: true }).click();
  await page.locator(".now-study", { hasText: id }).locator(".now-finding", { hasText: text }).waitFor();
  assert.equal(await page.locator(".now-first").count(), 0);
  await until(async () => assert.equal(await page.locator(".now-recent-job").count(), 4)); // two of them the reference's films
  await page.locator(".now-recent-job img").nth(3).waitFor();
  await shoot(page, "first-visit-now", { fullPage: true });
  expectNoComplaints(page);
});
