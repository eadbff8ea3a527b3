// The table of hard cases: a report that photonctl has just made, opened, kept, filtered and saved.

import assert from "node:assert/strict";
import { execFile } from "node:child_process";
import { readFile, writeFile } from "node:fs/promises";
import { join } from "node:path";
import { promisify } from "node:util";

import { axeClean, bin, openPage, shoot, startDaemon, test, until } from "./support.mjs";

const daemon = await startDaemon();
const file = join(daemon.data, "hard-cases.json");
const page = await openPage(daemon, "/studies/hard-cases");
const counts = (what, wanted) => until(async () => assert.equal(await what.count(), wanted));
const open = (path) => page.getByLabel("Report of hard cases").setInputFiles(path);

test("without a report it says how to make one", async () => {
  await page.getByText("photonctl hard-cases --short --json-report").waitFor();
  await shoot(page, "hard-cases-empty");
  await axeClean(page);
});

test("a report is shown case by method, and kept", async () => {
  const measured = ["hard-cases", "furnace-albedo-50", "furnace-mirror-50", "--short", "--seeds", "2", "--effort", "0.005", "-m", "path_tracing", "-m", "photon_mapping", "--photons", "500", "--keep-jobs"];
  await promisify(execFile)(join(bin, "photonctl"), [...measured, "--server", daemon.url, "--json-report", file]);
  const report = JSON.parse(await readFile(file, "utf8"));
  await open(file);
  await page.getByRole("heading", { name: `${report.summary.holds} of ` }).waitFor();
  await counts(page.locator(".hard-table tbody tr"), 2);
  await counts(page.locator(".hard-cell"), 2 * report.entries.length);
  await counts(page.locator(".hard-cell.holds"), report.summary.holds);
  await shoot(page, "hard-cases");
  await axeClean(page);
  await page.reload();
  await page.getByRole("heading", { name: `${report.summary.holds} of ` }).waitFor();
});

test("a cell says what was checked and links to its jobs", async () => {
  const report = JSON.parse(await readFile(file, "utf8"));
  const cell = report.cases[0].cells[0];
  await page.locator(".hard-cell").first().focus();
  await page.keyboard.press("Enter");
  await page.waitForURL(/cell=furnace-albedo-50/);
  const detail = page.locator(".hard-detail");
  await counts(detail.locator("tbody tr"), cell.checks.length);
  await axeClean(page);
  await detail.getByRole("link", { name: cell.jobs[0], exact: true }).click();
  await page.waitForURL(`**/jobs/${cell.jobs[0]}`);
  await page.goBack();
  await detail.waitFor(); // the address has the cell
  await detail.getByRole("button", { name: "Close the details" }).click();
});

test("what does not break is hidden on demand", async () => {
  await page.getByLabel("Only cases that break").check();
  await page.getByText("No case breaks.").waitFor();
  // The same report, but that one of its cells is said to break.
  const report = JSON.parse(await readFile(file, "utf8"));
  report.cases[1].cells[0].verdict = "breaks";
  const broken = join(daemon.data, "broken.json");
  await writeFile(broken, JSON.stringify(report));
  await open(broken);
  await page.locator(".hard-cell.breaks").waitFor();
  await until(async () => assert.deepEqual(await page.locator(".hard-table tbody th").allTextContents(), [report.cases[1].name]));
  await axeClean(page);
});

test("the table is saved for a spreadsheet and for a paper", async () => {
  const saved = async (name) => {
    const [download] = await Promise.all([page.waitForEvent("download"), page.getByRole("button", { name, exact: true }).click()]);
    return readFile(await download.path(), "utf8");
  };
  const csv = await saved("CSV");
  assert.equal(csv.trim().split("\r\n").length, 1 + (await daemonReport()).cases.flatMap((row) => row.cells).length);
  assert.ok((await saved("LaTeX")).includes("\\textbf{breaks}"));
});

const daemonReport = async () => JSON.parse(await readFile(file, "utf8"));

test("another file is refused with what is wrong with it", async () => {
  const other = join(daemon.data, "other.json");
  await writeFile(other, JSON.stringify({ entries: [], cases: [{}], summary: {} }));
  await open(other);
  await page.getByRole("alert").getByText("other.json cannot be shown: /cases/0 has no name or no cells").waitFor();
  await axeClean(page);
});
