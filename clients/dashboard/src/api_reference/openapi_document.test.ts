import { describe, expect, it } from "vitest";

import { curlOf, exampleOf, groupsOf, isFound, type OpenApi, typeText, withoutNull } from "./openapi_document";

const answers = { 200: { description: "as asked", content: { "application/json": {} } } };
const document: OpenApi = {
  info: { title: "photond", version: "1", description: "" },
  paths: {
    "/": { get: { operationId: "page", tags: ["dashboard"], summary: "The page", responses: {} } },
    "/readyz": { get: { operationId: "isReady", tags: ["daemon"], summary: "Ready", responses: answers } },
    "/v1/scenes/{scene}": { get: { operationId: "getScene", tags: ["scenes"], summary: "One scene", responses: answers, parameters: [{ name: "scene", in: "path", required: true, schema: { type: "string" } }] } },
    "/v1/jobs": {
      get: { operationId: "listJobs", tags: ["jobs"], summary: "Jobs, newest first", responses: answers, parameters: [{ name: "state", in: "query", schema: { enum: ["queued", "running"] } }] },
      post: { operationId: "submitJob", tags: ["jobs"], summary: "Submit", responses: answers, requestBody: { content: { "application/json": { schema: { $ref: "#/components/schemas/Stop" } } } } },
    },
    "/v1/jobs/{id}/preview.png": { get: { operationId: "getPreview", tags: ["jobs"], summary: "The image", responses: { 200: { description: "", content: { "image/png": {} } } } } },
  },
  components: {
    schemas: {
      Stop: {
        type: "object",
        required: ["name"],
        anyOf: [{ required: ["passes"] }, { required: ["seconds"] }],
        properties: { name: { type: "string", examples: ["it's"] }, passes: { anyOf: [{ type: "integer", minimum: 2 }, { type: "null" }] }, seconds: { type: "number" } },
      },
      Tree: { type: "object", required: ["left"], properties: { left: { $ref: "#/components/schemas/Tree" } } },
    },
  },
};
const all = groupsOf(document).flatMap(({ operations }) => operations);
const named = (id: string) => all.find(({ operationId }) => operationId === id)!;

describe("the API's reference", () => {
  it("has every operation once, jobs first and the dashboard's pages last", () => {
    expect(groupsOf(document).map(({ name }) => name)).toEqual(["jobs", "scenes", "daemon", "dashboard"]);
    expect(all.map(({ operationId }) => operationId)).toEqual(["listJobs", "submitJob", "getPreview", "getScene", "isReady", "page"]);
  });
  it("finds by all words, in names, texts and parameters", () => {
    const found = (words: string) => all.filter((operation) => isFound(operation, words)).map(({ operationId }) => operationId);
    expect(found("jobs state")).toEqual(["listJobs"]);
    expect(found("NEWEST")).toEqual(["listJobs"]);
    expect(found("post")).toEqual(["submitJob"]);
    expect(found("nonsense")).toEqual([]);
    expect(found(" ")).toHaveLength(6);
  });
  it("says types in words", () => {
    expect(typeText({ anyOf: [{ type: "integer", minimum: 1, maximum: 16 }, { type: "null" }] })).toBe("integer, 1 to 16 or null");
    expect(typeText({ type: "array", items: { $ref: "#/components/schemas/Stop" } })).toBe("list of Stop");
    expect(typeText({ type: ["string", "null"] })).toBe("string or null");
    expect(typeText({ enum: ["a", "b"] })).toBe("one of a, b");
    expect(typeText({ type: "number", minimum: 0, "x-unit": "m" })).toBe("number, at least 0 [m]");
    expect(typeText({ type: "object", additionalProperties: { type: "number" } })).toBe("object, of each name: number");
    expect(withoutNull({ type: "string" }).nullable).toBe(false);
  });
  it("makes examples of what is required, and of one of those of which one must be there", () => {
    expect(exampleOf(document, { $ref: "#/components/schemas/Stop" })).toEqual({ name: "it's", passes: 2 });
    expect(() => exampleOf(document, { $ref: "#/components/schemas/Tree" })).not.toThrow(); // it has no end
  });
  it("writes lines for a shell", () => {
    expect(curlOf(document, named("getScene"), "http://h")).toBe("curl 'http://h/v1/scenes/cornell-box'");
    expect(curlOf(document, named("submitJob"), "http://h")).toBe(`curl -X POST -H 'Content-Type: application/json' -d '{"name":"it'\\''s","passes":2}' 'http://h/v1/jobs'`);
    expect(curlOf(document, named("getPreview"), "http://h")).toBe("curl -o preview.png 'http://h/v1/jobs/J1/preview.png'");
  });
});
