// A job's request as people and programs write it: the daemon echoes it with every default filled in, and here it is
// without them. Of that are made the form that clones it and the lines that repeat it.

import type { Json, JobRequest, Method, MethodChoice, Reference, StopConditions } from "../api/types";
import { changedParameters } from "./parameter_form";

type Members = Record<string, unknown>;

const isEmpty = (value: unknown): boolean =>
  value === null ||
  value === undefined ||
  (Array.isArray(value) && value.length === 0) ||
  (typeof value === "object" && Object.keys(value as Members).length === 0);

/** The members that say something: neither null nor empty, and other than by default. */
function said(members: Members, defaults: Members = {}): Members {
  return Object.fromEntries(Object.entries(members).filter(([name, value]) => !isEmpty(value) && value !== defaults[name]));
}

export function minimalMethod(choice: MethodChoice, methods: Method[]): MethodChoice {
  const method = methods.find((other) => other.name === choice.name);
  const parameters = method ? changedParameters(method, choice.parameters) : choice.parameters;
  return said({ ...choice, parameters }, { device: "cpu" }) as unknown as MethodChoice;
}

export const minimalStop = (stop: StopConditions): StopConditions => said({ ...stop }) as StopConditions;

function minimalReference(reference: Reference | null | undefined, methods: Method[]): Reference | null {
  if (!reference || typeof reference === "string") return reference ?? null;
  return { method: minimalMethod(reference.method, methods), stop: minimalStop(reference.stop) };
}

const kDefaults = { seed: 1, priority: 0, glass: "as_stored", time: 0, shutter: 0, first_pass: 0 };

/** The least that gives the same job. Without the methods' schemas all parameters are kept. */
export function minimalRequest(request: JobRequest, methods: Method[]): JobRequest {
  const { scene, camera, image, method, stop, reference, environment, ...more } = request;
  return said(
    {
      scene,
      camera: camera ? said(camera, { aperture: 0 }) : null,
      image: said(image, { filter: "box" }),
      method: minimalMethod(method, methods),
      stop: minimalStop(stop),
      reference: minimalReference(reference, methods),
      environment: environment ? said(environment, { scale: 1, rotation: 0 }) : null,
      ...more,
    },
    kDefaults,
  ) as unknown as JobRequest;
}

// -- the lines that repeat it ------------------------------------------------------------------------------------------

/** Quoted for a POSIX shell. */
export const shellText = (text: string): string => `'${text.replaceAll("'", `'\\''`)}'`;

export function curlText(request: JobRequest, origin: string, withToken: boolean): string {
  return [
    `curl -X POST ${origin}/v1/jobs \\`,
    ...(withToken ? [`  -H "Authorization: Bearer $PHOTOND_TOKEN" \\`] : []),
    `  -H 'Content-Type: application/json' \\`,
    `  -d ${shellText(JSON.stringify(request))}`,
  ].join("\n");
}

/** A JSON value as a Python literal. */
export function pythonLiteral(value: Json | unknown, indent = "", width = 88): string {
  if (value === null || value === undefined) return "None";
  if (value === true) return "True";
  if (value === false) return "False";
  if (typeof value === "string") return JSON.stringify(value);
  if (typeof value !== "object") return String(value);
  const inner = `${indent}    `;
  const parts = Array.isArray(value)
    ? value.map((item) => pythonLiteral(item, inner, width))
    : Object.entries(value).map(([key, item]) => `${JSON.stringify(key)}: ${pythonLiteral(item, inner, width)}`);
  const [open, close] = Array.isArray(value) ? ["[", "]"] : ["{", "}"];
  const line = open + parts.join(", ") + close;
  if (indent.length + line.length <= width && !line.includes("\n")) return line;
  return `${open}\n${parts.map((part) => `${inner}${part},\n`).join("")}${indent}${close}`;
}

export function pythonText(request: JobRequest, origin: string): string {
  return [
    "from photond import Client",
    "",
    `client = Client(${JSON.stringify(origin)})`,
    `job = client.submit_request(${pythonLiteral(request)}).wait()`,
    "image = job.image()  # numpy, height × width × 3",
  ].join("\n");
}
