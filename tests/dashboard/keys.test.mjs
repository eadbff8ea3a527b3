// The list of keys that work now.
import assert from "node:assert/strict";

import { axeClean, openPage, shoot, startDaemon, test } from "./support.mjs";

const daemon = await startDaemon();

test("no key lies over a text", async () => {
  const page = await openPage(daemon, "/jobs");
  await page.getByText("Nothing has been rendered yet.").waitFor();
  await page.keyboard.press("?");
  const keys = page.getByRole("dialog", { name: "Keys" });
  await keys.waitFor();
  const lines = await keys.evaluate((shown) =>
    [...shown.querySelectorAll("dl > div")].map((line) => ({
      keys: [...line.querySelectorAll("kbd")].map((key) => key.getBoundingClientRect().right),
      text: line.querySelector("dd").getBoundingClientRect().left,
    })),
  );
  assert.ok(lines.some((line) => line.keys.length > 1), "several keys in a line");
  assert.deepEqual(lines.filter((line) => line.keys.some((right) => right > line.text)), []);
  await axeClean(page);
  await shoot(page, "keys");
});
