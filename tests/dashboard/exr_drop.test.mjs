// An EXR of photond dropped on a room opens the form with the request that it was rendered by.
import assert from "node:assert/strict";

import { expectNoComplaints, openPage, shoot, smallJob, startDaemon, test } from "./support.mjs";

const daemon = await startDaemon();

/** The first bytes of an EXR with a string attribute. */
function exr(name, value) {
  const size = Buffer.alloc(4);
  size.writeInt32LE(Buffer.byteLength(value));
  return Buffer.concat([Buffer.from([0x76, 0x2f, 0x31, 0x01, 2, 0, 0, 0]), Buffer.from(`${name}\0string\0`), size, Buffer.from(value), Buffer.from([0])]);
}

async function drop(page, name, bytes) {
  const transfer = await page.evaluateHandle(
    ({ name, bytes }) => {
      const made = new DataTransfer();
      made.items.add(new File([Uint8Array.from(bytes)], name));
      return made;
    },
    { name, bytes: [...bytes] },
  );
  for (const type of ["dragenter", "dragover", "drop"]) await page.dispatchEvent("main", type, { dataTransfer: transfer });
}

test("a dropped EXR fills the form with its request", async () => {
  const job = await daemon.run(smallJob({ image: { width: 40, height: 24 }, stop: { passes: 3 }, seed: 7 }));
  const image = await fetch(`${daemon.url}/v1/jobs/${job.id}/image.exr`);
  const page = await openPage(daemon, "/jobs");
  await page.getByRole("heading", { name: "Jobs" }).waitFor();
  await drop(page, "kept.exr", Buffer.from(await image.arrayBuffer()));
  await page.getByRole("heading", { name: "Render, from kept.exr" }).waitFor();
  await page.getByText("As JSON").click();
  const request = JSON.parse(await page.getByLabel("The request as JSON").inputValue());
  assert.deepEqual([request.scene, request.image, request.stop, request.seed], ["cornell-box", { width: 40, height: 24 }, { passes: 3 }, 7]);
  await shoot(page, "render-from-exr");

  // On the form itself, another one takes its place.
  await drop(page, "kept.exr", exr("photond:request", JSON.stringify({ ...job.request, seed: 8 })));
  await page.waitForFunction(() => /"seed": 8/.test(document.querySelector("textarea[aria-label='The request as JSON']")?.value ?? "") || (document.querySelector("details.render-json summary")?.click(), false));
  expectNoComplaints(page);
});

test("what is wrong with it is said", async () => {
  const page = await openPage(daemon, "/render", { expected: /status of 4(04|22)/ });
  await page.getByRole("heading", { name: "Render" }).waitFor();
  await drop(page, "other.exr", exr("comment", "by another program"));
  await page.getByText("other.exr cannot be repeated: it carries no photond:request").waitFor();
  await drop(page, "gone.exr", exr("photond:request", JSON.stringify({ ...smallJob(), scene: "0123456789abcdef" })));
  await page.getByText("gone.exr was rendered of the scene 0123456789abcdef, which this daemon has not").waitFor();
  expectNoComplaints(page);
});
