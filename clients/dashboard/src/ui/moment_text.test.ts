import { expect, it } from "vitest";

import { momentText } from "./moment_text";

it("says a moment in words", () => {
  expect(momentText({})).toBe(null);
  expect(momentText({ animation: null, time: 0, shutter: 0 })).toBe(null);
  expect(momentText({ animation: "walk", time: 1.5, shutter: 0.02 })).toBe("1.5 s into “walk”, the shutter open for 20 ms");
  expect(momentText({ animation: 0, time: 0, shutter: 0 })).toBe("0 s into animation 0");
  expect(momentText({ time: 2 })).toBe("2 s into animation 0");
});
