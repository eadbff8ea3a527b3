// The request that is being written: where it starts, what was changed, and where its faults belong.

import type { Fault, Job, JobRequest, Json, Method, Scene, SceneCamera } from "../api/types";
import { boundedAspect, sizeOfAspect } from "../ui/aspect";
import { minimalRequest } from "../ui/job_request";
import { sceneNamed } from "./scenes";

export const kDefaultScene = "cornell-box";

/** What a side of whole pixels makes of a shape. */
export const kSameShape = 0.015;

/** What a render begins with when nothing is said: small and quick, by the method the others are measured by. */
export const kFirstRequest: JobRequest = {
  scene: kDefaultScene,
  image: { width: 512, height: 512 },
  method: { name: "path_tracing" },
  stop: { passes: 64 },
};

/** The moment an address asks for, with animations as on the command line: digits are an index. */
function momentOfQuery({ animation, time, shutter }: Record<string, string>): Pick<JobRequest, "animation" | "time" | "shutter"> {
  const seconds = (name: "time" | "shutter", text: string | undefined) => (Number(text) ? { [name]: Number(text) } : {});
  return {
    ...(animation ? { animation: /^\d+$/.test(animation) ? Number(animation) : animation } : {}),
    ...seconds("time", time),
    ...seconds("shutter", shutter),
  };
}

/** How the picture is to be shown once it is rendered, as the page of its job reads it: as the view was that it comes from. */
export function shownBy({ exposure, curve }: Record<string, string | undefined>): { exposure: string; curve: string | null } | null {
  const stops = Number(exposure);
  if (!exposure || !Number.isFinite(stops)) return null;
  return { exposure: String(stops), curve: curve === "filmic" ? curve : null };
}

/** The request an address asks for, but for the job that `from` names. */
export function requestOfQuery(query: Record<string, string>, camera: JobRequest["camera"], scenes: Scene[] = []): JobRequest {
  const size = (text: string | undefined, otherwise: number) => (Number(text) >= 1 ? Math.floor(Number(text)) : otherwise);
  const scene = query.scene || kFirstRequest.scene;
  const { image } = inShapeOfCamera({ ...kFirstRequest, scene, ...(camera ? { camera } : {}) }, scenes);
  return {
    ...kFirstRequest,
    scene,
    ...(camera ? { camera } : {}),
    image: { width: size(query.width, image.width), height: size(query.height, image.height) },
    method: query.method ? { name: query.method } : kFirstRequest.method,
    ...momentOfQuery(query),
  };
}

/** The shape of the image that the request's camera asks for; null where it asks for none, or has a view of its own. */
export function aspectOfCamera(request: JobRequest, scenes: Scene[]): number | null {
  if (request.camera?.look_at) return null;
  const cameras = sceneNamed(scenes, request.scene)?.cameras ?? [];
  const name = request.camera?.name;
  return (name ? cameras.find((camera) => camera.name === name) : cameras[0])?.aspect ?? null;
}

/** The request with about as many pixels, in the shape that its camera asks for. */
export function inShapeOfCamera(request: JobRequest, scenes: Scene[]): JobRequest {
  const aspect = aspectOfCamera(request, scenes);
  const { width, height } = request.image;
  if (aspect === null || Math.abs(width / height / aspect - 1) < kSameShape) return request;
  return { ...request, image: { ...request.image, ...sizeOfAspect(boundedAspect(aspect), width * height) } };
}

export const requestOfJob = (job: Job, methods: Method[]): JobRequest => minimalRequest(job.request, methods);

const isNothing = (value: unknown): boolean =>
  value === undefined ||
  value === null ||
  value === "" ||
  (Array.isArray(value) && value.length === 0) ||
  (typeof value === "object" && Object.keys(value).length === 0);

/** The request with a member changed; one that says nothing is left out. */
export function withMember(request: JobRequest, name: string, value: unknown): JobRequest {
  const { [name]: _, ...rest } = request;
  return (isNothing(value) ? rest : { ...rest, [name]: value }) as JobRequest;
}

/** Members of a member, likewise: camera, environment. */
export function withInner(request: JobRequest, name: string, changes: Record<string, unknown>): JobRequest {
  const inner = { ...((request[name] as Record<string, unknown> | null | undefined) ?? {}), ...changes };
  return withMember(request, name, Object.fromEntries(Object.entries(inner).filter(([, value]) => !isNothing(value))));
}

/** The faults at a pointer and below it. */
export const faultsBelow = (faults: Fault[], pointer: string): Fault[] =>
  faults.filter((fault) => fault.pointer === pointer || fault.pointer.startsWith(`${pointer}/`));

/** The same with pointers relative to it, as a form of a part has them. */
export const faultsWithin = (faults: Fault[], pointer: string): Fault[] =>
  faultsBelow(faults, pointer).map((fault) => ({ ...fault, pointer: fault.pointer.slice(pointer.length) }));

export interface ParsedText {
  request: JobRequest | null;
  fault: string | null;
}

/** Reads a request that was written by hand. What is in it is for the daemon to judge; that it has the parts a form needs, for us. */
export function parseRequest(text: string): ParsedText {
  let value: Json;
  try {
    value = JSON.parse(text) as Json;
  } catch (failure) {
    return { request: null, fault: `This is no JSON: ${(failure as Error).message}` };
  }
  const isObject = (part: Json | undefined): part is { [key: string]: Json } => typeof part === "object" && part !== null && !Array.isArray(part);
  if (!isObject(value)) return { request: null, fault: "A request is an object: { … }" };
  for (const name of ["image", "method", "stop"]) if (!isObject(value[name])) return { request: null, fault: `“${name}” is missing, or no object` };
  if (typeof value.scene !== "string") return { request: null, fault: "“scene” is missing, or no text" };
  return { request: value as unknown as JobRequest, fault: null };
}

/** "a b" as labels and back: one a line, KEY=VALUE. */
export const labelsText = (labels: Record<string, string> | undefined): string =>
  Object.entries(labels ?? {})
    .map(([key, value]) => `${key}=${value}`)
    .join("\n");

export function labelsOf(text: string): Record<string, string> {
  const lines = text.split("\n").map((line) => line.trim());
  return Object.fromEntries(lines.filter(Boolean).map((line) => {
    const [key = "", value = ""] = line.split(/=(.*)/s);
    return [key.trim(), value.trim()];
  }));
}

/** The camera a request is about among those of its scene: its own name, "own" for a view of its own, else the first. */
export function cameraChoice(request: JobRequest, cameras: SceneCamera[]): string {
  if (request.camera?.look_at) return "own";
  return request.camera?.name ?? cameras[0]?.name ?? "";
}

/** Random, so that a repeat of this submission, and nothing else, carries it. */
export function newKey(): string {
  const bytes = crypto.getRandomValues(new Uint8Array(16));
  return `dashboard-${[...bytes].map((byte) => byte.toString(16).padStart(2, "0")).join("")}`;
}

// -- kept while one is elsewhere ---------------------------------------------------------------------------------------

const keyOf = (search: string): string => `photond.render ${search}`;

/** What was changed of the form that this address starts with; null: nothing. */
export function keptDraft(search: string): JobRequest | null {
  const text = sessionStorage.getItem(keyOf(search));
  return text ? parseRequest(text).request : null;
}

export function keepDraft(search: string, request: JobRequest | null): void {
  if (request) sessionStorage.setItem(keyOf(search), JSON.stringify(request));
  else sessionStorage.removeItem(keyOf(search));
}
