import { describe, expect, it } from "vitest";

import type { JobSummary } from "../api/types";
import { jobGroups } from "./job_groups";

const job = (id: string, scene: string, method: string, width = 64, role = "render"): JobSummary => ({ id, scene, method, width, height: 64, role }) as JobSummary;

describe("jobs to compare", () => {
  it("are of one scene and size, each method's newest before older ones, and the reference first", () => {
    const jobs = [
      job("J9", "box", "a"), job("J8", "box", "a"), job("J7", "sponza", "a"), job("J6", "box", "b"),
      job("J5", "box", "a", 128), job("J4", "box", "c", 64, "reference"), job("J3", "sponza", "b"),
    ];
    expect(jobGroups(jobs, 3).map((group) => [group.scene, group.jobs.map((one) => one.id)])).toEqual([
      ["box", ["J4", "J9", "J6"]],
      ["sponza", ["J7", "J3"]],
    ]);
    expect(jobGroups(jobs, 9)[0]!.jobs.map((one) => one.id)).toEqual(["J4", "J9", "J6", "J8"]);
  });
});
