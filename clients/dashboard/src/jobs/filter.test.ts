import { describe, expect, it } from "vitest";

import { filterOfQuery, filterText, kEverything, matches, parseFilter, queryOfFilter, suggestionsFor } from "./filter";
import type { JobSummary } from "../api/types";

const known = { methods: ["path_tracing", "photon_mapping"], scenes: ["cornell-box", "my room"], devices: ["cpu"], labels: ["study=x"] };

describe("the filter's words", () => {
  it("are read, and written again", () => {
    const text = 'J12 state:failed,queued method:path_tracing scene:"my room" device:gpu:0 label:study=a:b role:render';
    const { filter, faults } = parseFilter(text);
    expect(faults).toEqual([]);
    expect(filter).toEqual({
      ids: ["J12"], states: ["failed", "queued"], method: "path_tracing", scene: "my room", device: "gpu:0", label: "study=a:b", role: "render",
    });
    expect(parseFilter(filterText(filter)).filter).toEqual(filter);
    const query = Object.fromEntries(Object.entries(queryOfFilter(filter)).filter(([, value]) => value !== null)) as Record<string, string>;
    expect(filterOfQuery(query)).toEqual(filter);
  });
  it("name what says nothing, and leave it aside", () => {
    const { filter, faults } = parseFilter("state:broken method:a method:b colour:red method:");
    expect(filter).toEqual({ ...kEverything, method: "a" });
    expect(faults).toHaveLength(3);
    expect(faults[0]).toContain("“broken” is none of queued, running");
    expect(faults[1]).toBe("method: can be given once");
    expect(faults[2]).toContain("“colour:red” is no filter");
  });
  it("ask nothing for what is not said", () => {
    expect(queryOfFilter(kEverything)).toEqual({ id: null, state: null, method: null, scene: null, device: null, label: null, role: null });
    expect(filterOfQuery({ state: "failed,nonsense", other: "1" }).states).toEqual(["failed"]);
  });
  it("are tried on jobs asked for by name", () => {
    const job = { state: "failed", method: "path_tracing", scene: "cornell-box", device: "cpu", role: "render", labels: { study: "x=y" } };
    const fits = (text: string) => matches(parseFilter(text).filter, job as unknown as JobSummary);
    expect(["state:failed,queued", "label:study", "label:study=x=y", "device:cpu", ""].map(fits)).toEqual([true, true, true, true, true]);
    expect(["state:queued", "label:other", "label:study=x", "method:photon_mapping", "role:merged"].map(fits)).toEqual(Array(5).fill(false));
  });
});

describe("suggestions", () => {
  const shown = (text: string, caret = text.length) => suggestionsFor(text, caret, known).map((suggestion) => suggestion.shown);
  it("begin with the names of filters, and values where a word is one", () => {
    expect(shown("")).toEqual(["state:", "method:", "scene:", "device:", "label:", "role:"]);
    expect(shown("s")).toEqual(["state:", "scene:", "state:succeeded", "label:study=x"]);
    expect(shown("failed")).toEqual(["state:failed"]);
  });
  it("go on with values, quoted where needed", () => {
    expect(shown("method:map")).toEqual(["method:photon_mapping"]);
    expect(shown("scene:")).toEqual(["scene:cornell-box", 'scene:"my room"']);
    expect(shown("state:failed,q")).toEqual(["state:failed,queued"]);
  });
  it("replace the word at the caret and keep the rest", () => {
    const text = "stat method:path_tracing";
    expect(suggestionsFor(text, 4, known)[0]).toMatchObject({ text: "state: method:path_tracing", caret: 6 });
    expect(suggestionsFor("state:fai scene:x", 9, known)[0]).toMatchObject({ text: "state:failed scene:x", caret: 13 });
  });
});
