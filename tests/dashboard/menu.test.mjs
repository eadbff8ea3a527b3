// The menu of a narrow window: whatever one does after opening it closes it, however soon.

import assert from "node:assert/strict";

import { expectNoComplaints, kTelephone, openPage, startDaemon, test } from "./support.mjs";

const daemon = await startDaemon();

const kWaysToLeave = {
  "Escape": () => document.body.dispatchEvent(new KeyboardEvent("keydown", { key: "Escape", bubbles: true })),
  "a touch beside it": () => document.querySelector("#room").dispatchEvent(new PointerEvent("pointerdown", { bubbles: true })),
  "the focus of something else": () => document.querySelector("#room").dispatchEvent(new FocusEvent("focusin", { bubbles: true })),
  "the choice of a room": () => document.querySelector('.rooms a[href="/scenes"]').click(),
};

for (const [way, leave] of Object.entries(kWaysToLeave))
  test(`is closed by ${way} before the first frame that shows it`, async () => {
    const page = await openPage(daemon, "/sequences", kTelephone);
    await page.getByText("0 running, 0 waiting").waitFor();
    // In one task of the page, in which no frame is drawn and no timer ends, as when the machine is busy.
    const states = await page.evaluate(`(async () => {
      const isOpen = () => document.querySelector(".bar-menu").ariaExpanded === "true";
      const comesTo = async (wanted) => {
        for (let steps = 0; steps < 1000 && isOpen() !== wanted; ++steps) await null;
        return isOpen();
      };
      document.querySelector(".bar-menu").click();
      const opened = await comesTo(true);
      (${leave})();
      return [opened, await comesTo(false)];
    })()`);
    assert.deepEqual(states, [true, false]);
    await page.getByRole("link", { name: "Sequences", exact: true }).waitFor({ state: "hidden" });
    expectNoComplaints(page);
  });
