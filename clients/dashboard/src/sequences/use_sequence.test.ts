import { expect, test } from "vitest";

import type { JobState, SequenceSummary } from "../api/types";
import { areFramesDue } from "./use_sequence";

function summary(state: JobState, succeeded: number): SequenceSummary {
  return { state, job_states: { queued: 9 - succeeded, running: 1, succeeded, failed: 0, cancelled: 0 } } as SequenceSummary;
}

test("frames are read again when others have ended, a long list seldom, and at the end at once", () => {
  const before = summary("running", 2);
  expect(areFramesDue(before, summary("running", 2), 10, 60_000)).toBe(false);
  expect(areFramesDue(before, summary("running", 3), 10, 1000)).toBe(true);
  expect(areFramesDue(before, summary("running", 3), 10_000, 1000)).toBe(false);
  expect(areFramesDue(before, summary("running", 3), 10_000, 20_000)).toBe(true);
  expect(areFramesDue(before, summary("cancelled", 3), 10_000, 0)).toBe(true);
});
