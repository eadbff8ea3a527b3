// The reference of the HTTP interface: every operation of the daemon's own document, found by words, with examples that work.

import assert from "node:assert/strict";

import { axeClean, fitsItsWidth, openPage, shoot, smallJob, startDaemon, test, until } from "./support.mjs";

const daemon = await startDaemon();

test("every operation is there by its subject, is found by words and says what it takes and gives", async () => {
  const page = await openPage(daemon, "/");
  const before = await page.evaluate(() => performance.getEntriesByType("resource").filter(({ name }) => name.includes("openapi")).length);
  assert.equal(before, 0, "the document is fetched when somebody asks for it");
  await page.getByRole("link", { name: "by HTTP too" }).click();
  await page.getByRole("heading", { level: 1, name: "By HTTP" }).waitFor();

  const document = await daemon.get("/v1/openapi.json");
  const operations = Object.entries(document.paths).flatMap(([path, methods]) => Object.entries(methods).map(([method, operation]) => ({ path, method, ...operation })));
  await page.getByText(`${operations.length} operations`).waitFor();
  const listed = await page.locator(".api-operation > summary").evaluateAll((found) => found.map((one) => `${one.querySelector(".api-method").textContent} ${one.querySelector(".api-path").textContent}`));
  assert.deepEqual([...listed].sort(), operations.map(({ method, path }) => `${method.toUpperCase()} ${path}`).sort());
  const subjects = await page.locator(".api-all h2").allInnerTexts();
  assert.deepEqual(subjects.map((name) => name.toLowerCase()).sort(), [...new Set(operations.map(({ tags }) => tags[0]))].sort());
  assert.equal(subjects[0].toLowerCase(), "jobs");
  await shoot(page, "api");
  await axeClean(page);

  await page.getByLabel("Find operations").fill("submit job");
  await until(async () => assert.ok((await page.locator(".api-operation").count()) < 6));
  const submit = page.locator("#op-submitJob");
  await submit.locator("summary").first().click();
  await submit.getByText("Idempotency-Key").waitFor();
  await submit.getByText("the same key and body give the same job").waitFor();
  const body = submit.locator(".api-details > section", { has: page.getByRole("heading", { name: "Body" }) });
  const members = body.locator(".api-members").first().locator(":scope > li");
  const { properties, required } = document.components.schemas.JobRequest;
  assert.deepEqual(await members.locator(":scope > code").allInnerTexts(), Object.keys(properties));
  assert.deepEqual((await members.filter({ has: page.locator(":scope > .api-required") }).locator(":scope > code").allInnerTexts()).sort(), [...required].sort());
  await submit.locator(".api-answer", { hasText: "202" }).locator("summary").first().click();
  await submit.locator(".api-answer", { hasText: "202" }).locator(":scope > div > .api-members > li > code", { hasText: /^passes_done$/ }).waitFor();
  await shoot(page, "api-operation", { fullPage: true });
  await axeClean(page);
  // A link brings it back, opened.
  await until(() => assert.equal(new URL(page.url()).searchParams.get("op"), "submitJob"));
  await page.reload();
  await page.locator("#op-submitJob .api-example").waitFor();

  // The example is what the daemon takes.
  const line = (await page.locator("#op-submitJob .api-example").innerText()).trim();
  const sent = JSON.parse(/-d '(.*)' '/.exec(line)[1]);
  assert.ok(line.endsWith(`'${daemon.url}/v1/jobs'`), line);
  await daemon.json("POST", "/v1/jobs?dry_run=true", sent);

  await page.getByLabel("Find operations").fill("no such thing");
  await page.getByText("Nothing is found by these words.").waitFor();
});

test("the reference fits a telephone", async () => {
  await daemon.run(smallJob());
  const page = await openPage(daemon, "/api?op=submitJob", { width: 390, height: 844 });
  await page.locator("#op-submitJob .api-example").waitFor();
  await fitsItsWidth(page);
  await shoot(page, "api-narrow");
  // What axe says of the longest operation does not depend on the width, and takes seconds: here it looks at another one.
  await page.goto(`${daemon.url}/api?op=cancelJob`);
  await page.locator("#op-cancelJob .api-example").waitFor();
  await axeClean(page);
});
