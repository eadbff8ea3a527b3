// The daemon's OpenAPI document as its page reads it: operations by subject, found by words, and the parts of a schema.

export type Schema = {
  $ref?: string;
  type?: string | string[];
  description?: string;
  enum?: unknown[];
  const?: unknown;
  default?: unknown;
  examples?: unknown[];
  minimum?: number;
  maximum?: number;
  pattern?: string;
  format?: string;
  properties?: Record<string, Schema>;
  required?: string[];
  items?: Schema;
  prefixItems?: Schema[];
  minItems?: number;
  additionalProperties?: Schema | boolean;
  anyOf?: Schema[];
  oneOf?: Schema[];
  allOf?: Schema[];
  "x-unit"?: string;
  [more: string]: unknown;
};

export interface Parameter {
  name: string;
  in: "path" | "query" | "header";
  required?: boolean;
  description?: string;
  schema: Schema;
}

type Content = Record<string, { schema?: Schema }>;

interface Described {
  operationId: string;
  summary: string;
  tags?: string[];
  parameters?: Parameter[];
  requestBody?: { content: Content };
  responses: Record<string, { description: string; content?: Content }>;
  security?: unknown[];
}

export interface OpenApi {
  info: { title: string; version: string; description: string };
  paths: Record<string, Record<string, Described>>;
  components: { schemas: Record<string, Schema> };
}

export interface Operation extends Described {
  method: string;
  path: string;
}

export interface Group {
  name: string;
  operations: Operation[];
}

const kMethods = ["get", "post", "patch", "put", "delete"];
/** Subjects that people come for first; others follow by name. */
const kFirst = ["jobs", "scenes", "images", "comparisons", "sequences", "render", "methods"];
const kPages = "dashboard";

/** All operations by their tag, the pages that people look at last: a client has no use for them. */
export function groupsOf(document: OpenApi): Group[] {
  const groups = new Map<string, Operation[]>();
  for (const [path, methods] of Object.entries(document.paths))
    for (const method of kMethods) {
      const described = methods[method];
      if (!described) continue;
      const operation = { ...described, method, path };
      const name = described.tags?.[0] ?? "others";
      groups.set(name, [...(groups.get(name) ?? []), operation]);
    }
  const rank = (name: string) => (name === kPages ? 1000 : kFirst.includes(name) ? kFirst.indexOf(name) : 100);
  return [...groups]
    .map(([name, operations]) => ({ name, operations }))
    .sort((a, b) => rank(a.name) - rank(b.name) || a.name.localeCompare(b.name));
}

/** Whether every word is somewhere in what is said of the operation. */
export function isFound(operation: Operation, words: string): boolean {
  const text = [operation.method, operation.path, operation.operationId, operation.summary, ...(operation.parameters ?? []).flatMap(({ name, description }) => [name, description ?? ""])].join(" ").toLowerCase();
  return words.toLowerCase().split(/\s+/).filter(Boolean).every((word) => text.includes(word));
}

/** The name in "#/components/schemas/NAME". */
export const nameOfRef = (ref: string): string => decodeURIComponent(ref.slice(ref.lastIndexOf("/") + 1));

export function resolved(document: OpenApi, schema: Schema): Schema {
  return schema.$ref ? (document.components.schemas[nameOfRef(schema.$ref)] ?? {}) : schema;
}

const isNull = (schema: Schema) => schema.type === "null";
/** What a schema is beside null, and whether null is allowed. */
export function withoutNull(schema: Schema): { schema: Schema; nullable: boolean } {
  const choices = schema.anyOf ?? schema.oneOf;
  if (choices?.some(isNull)) {
    const others = choices.filter((choice) => !isNull(choice));
    const rest = { ...schema };
    delete rest.anyOf;
    delete rest.oneOf;
    return { schema: others.length === 1 ? { ...rest, ...others[0] } : { ...rest, anyOf: others }, nullable: true };
  }
  if (Array.isArray(schema.type) && schema.type.includes("null")) {
    const types = schema.type.filter((type) => type !== "null");
    return { schema: { ...schema, type: types.length === 1 ? types[0]! : types }, nullable: true };
  }
  return { schema, nullable: false };
}

/** A type in a few words: "integer, 1 to 16", "list of Job", "one of a, b or null". */
export function typeText(schema: Schema): string {
  const { schema: own, nullable } = withoutNull(schema);
  const or = nullable ? " or null" : "";
  if (own.$ref) return nameOfRef(own.$ref) + or;
  if (own.const !== undefined) return JSON.stringify(own.const) + or;
  if (own.enum) return `one of ${own.enum.map((value) => (value === null ? "null" : String(value))).join(", ")}${or}`;
  const choices = own.anyOf ?? own.oneOf;
  if (choices && !own.properties) return choices.map(typeText).join(", or ") + or;
  if (own.type === "array" || own.items) return `list of ${own.items ? typeText(own.items) : own.prefixItems ? own.prefixItems.map(typeText).join(", ") : "anything"}${own.minItems !== undefined && own.minItems === own.maxItems ? `, ${own.minItems} of them` : ""}${or}`;
  if (own.type === "object" && !own.properties && typeof own.additionalProperties === "object") return `object, of each name: ${typeText(own.additionalProperties)}${or}`;
  const type = Array.isArray(own.type) ? own.type.join(" or ") : (own.type ?? "anything");
  const { minimum, maximum } = own;
  const range = minimum !== undefined && maximum !== undefined ? `, ${minimum} to ${maximum}` : minimum !== undefined ? `, at least ${minimum}` : maximum !== undefined ? `, at most ${maximum}` : "";
  return `${type}${range}${own["x-unit"] ? ` [${own["x-unit"]}]` : ""}${or}`;
}

/** An example of what a schema takes: what is required, by its example, its default, or its least value. */
export function exampleOf(document: OpenApi, schema: Schema, depth = 0): unknown {
  const { schema: own } = withoutNull(resolved(document, schema));
  if (depth > 5) return null;
  if (own.examples?.length) return own.examples[0];
  if (own.default !== undefined) return own.default;
  if (own.const !== undefined) return own.const;
  if (own.enum?.length) return own.enum.find((value) => value !== null) ?? null;
  if (own.properties) {
    const needed = new Set(own.required ?? []);
    const names = Object.keys(own.properties).filter((name) => needed.has(name));
    // Of members of which one at least must be there, the first such.
    if (own.anyOf?.every((choice) => choice.required)) names.push(...own.anyOf[0]!.required!.filter((name) => !names.includes(name)));
    return Object.fromEntries(names.map((name) => [name, exampleOf(document, own.properties![name]!, depth + 1)]));
  }
  const choice = own.anyOf?.[0] ?? own.oneOf?.[0];
  if (choice) return exampleOf(document, choice, depth + 1);
  if (own.$ref) return exampleOf(document, own, depth + 1);
  switch (Array.isArray(own.type) ? own.type[0] : own.type) {
    case "array": return Array.from({ length: own.minItems ?? 1 }, () => exampleOf(document, own.items ?? {}, depth + 1));
    case "integer": case "number": return Math.max(1, own.minimum ?? 1);
    case "boolean": return true;
    case "string": return "text";
    case "object": return {};
    default: return null;
  }
}

/** What people render first, where the document's own words would make an example that the daemon refuses. */
const kBodies: Record<string, unknown> = {
  JobRequest: { scene: "cornell-box", image: { width: 512, height: 512 }, method: { name: "path_tracing" }, stop: { passes: 64 } },
  ComparisonRequest: {
    scene: "cornell-box",
    image: { width: 256, height: 256 },
    reference: { method: { name: "path_tracing" }, stop: { passes: 1024 } },
    entries: [
      { label: "all bounces", method: { name: "path_tracing" } },
      { label: "one bounce", method: { name: "path_tracing", parameters: { indirect_bounces: 1 } } },
    ],
    stop: { seconds: 10 },
    seeds: [1, 2],
  },
};

const quoted = (text: string) => `'${text.replaceAll("'", "'\\''")}'`;

/** The operation as a line for a shell; null for bodies that are no JSON, but for files. */
export function curlOf(document: OpenApi, operation: Operation, origin: string): string {
  const path = operation.path.replaceAll(/\{(\w+)\}/g, (_, name: string) => (name === "scene" ? "cornell-box" : name === "id" && operation.path.startsWith("/v1/jobs") ? "J1" : name.toUpperCase()));
  const needed = (operation.parameters ?? []).filter((parameter) => parameter.in === "query" && parameter.required);
  const query = needed.map(({ name, schema }) => `${name}=${encodeURIComponent(String(exampleOf(document, schema)))}`).join("&");
  const parts = ["curl"];
  if (operation.method !== "get") parts.push("-X", operation.method.toUpperCase());
  const content = operation.requestBody?.content ?? {};
  const [media] = Object.keys(content);
  if (media === "application/json") {
    const schema = content[media]!.schema ?? {};
    const body = (schema.$ref && kBodies[nameOfRef(schema.$ref)]) || exampleOf(document, schema);
    parts.push("-H", quoted("Content-Type: application/json"), "-d", quoted(JSON.stringify(body)));
  } else if (media) parts.push("-H", quoted(`Content-Type: ${media}`), "--data-binary", "@FILE");
  const answers = Object.keys(operation.responses["200"]?.content ?? operation.responses["201"]?.content ?? {});
  if (answers.length > 0 && !/json|text|event-stream/.test(answers[0]!)) parts.push("-o", path.slice(path.lastIndexOf("/") + 1).replaceAll(/[^\w.]/g, "") || "file");
  parts.push(quoted(`${origin}${path}${query ? `?${query}` : ""}`));
  return parts.join(" ");
}
