// A study and a job that were disturbed: what the pages say of it, and the button that runs it again.
import assert from "node:assert/strict";
import { spawn } from "node:child_process";
import { cpus } from "node:os";

import { axeClean, expectNoComplaints, openPage, shoot, startDaemon, test, until } from "./support.mjs";

const daemon = await startDaemon();

test("a disturbed study offers to run its jobs again", async () => {
  const loops = cpus().map(() => spawn(process.execPath, ["-e", "for (;;);"]));
  let study;
  try {
    study = await daemon.json("POST", "/v1/comparisons", {
      scene: "cornell-box",
      image: { width: 48, height: 48 },
      reference: { method: { name: "path_tracing" }, stop: { passes: 64 } },
      entries: [{ label: "paths", method: { name: "path_tracing" } }],
      stop: { seconds: 0.4 },
    });
    study = await daemon.over(`/v1/comparisons/${study.id}`);
  } finally {
    for (const loop of loops) loop.kill("SIGKILL");
  }
  const [job] = study.jobs;
  if (!job.warning) return; // a kernel that does not say how long threads wait
  const page = await openPage(daemon, `/studies/${study.id}`);
  await page.getByText(`${job.id} lost`).waitFor();
  await axeClean(page);
  await shoot(page, "study-disturbed");
  await page.getByRole("button", { name: `Run ${job.id} again` }).click();
  // Which of the two counts depends on what else ran: that both are there does not.
  await until(async () => assert.notEqual((await daemon.get(`/v1/comparisons/${study.id}`)).repeats, 0));
  study = await daemon.over(`/v1/comparisons/${study.id}`);
  assert.equal(study.repeats, 1);
  await page.getByText(study.warnings[0]).waitFor();
  await page.goto(`${daemon.url}/jobs/${job.id}`);
  await page.getByRole("status").getByText(job.warning).waitFor();
  await shoot(page, "job-disturbed");
  await page.getByRole("button", { name: "Run it again" }).click();
  await page.waitForURL(`**/jobs/${`J${Math.max(...study.jobs[0].runs.map((run) => Number(run.id.slice(1)))) + 1}`}`);
  expectNoComplaints(page);
});
