import { describe, expect, it } from "vitest";

import { passesText, progressText, secondsLeft } from "./progress";

describe("how far a job is", () => {
  it("goes by the time taken so far", () => {
    expect(secondsLeft({ progress: 0.25, seconds: 2 })).toBe(6);
    expect(secondsLeft({ progress: 0, seconds: 2 })).toBeNull();
  });
  it("is said with what is left, where that can be told", () => {
    expect(progressText({ progress: 0.25, seconds: 2 })).toBe("25 %, about 6 s left");
    expect(progressText({ progress: 0, seconds: 0 })).toBe("0 %");
    expect(progressText({ progress: 1, seconds: 9 })).toBe("100 %");
    expect([passesText(1, 2), passesText(2048, 14.13)]).toEqual(["1 pass in 2 s", "2,048 passes in 14.1 s"]);
  });
});
