// Requests to the daemon: the token of who looks, and its problems as errors that name every fault.

import { askSlowly } from "./shared";
import { needsToken, token } from "./token";
import { authorization } from "./token_header";
import type { Fault, ProblemBody } from "./types";

/** The daemon's answer to a request it did not carry out (RFC 9457). */
export class Problem extends Error {
  readonly status: number;
  readonly title: string;
  readonly faults: Fault[];
  /** When to ask again; null where asking again does not help. */
  readonly retryAfterSeconds: number | null;
  constructor(body: ProblemBody, retryAfterSeconds: number | null = null) {
    super(body.detail || body.title);
    this.retryAfterSeconds = retryAfterSeconds;
    this.status = body.status;
    this.title = body.title;
    this.faults = body.errors ?? [];
  }
}

/** Nobody answered. */
export class Unreachable extends Error {}

const kWithoutBody = [204, 205, 304]; // a Response refuses one

const withToken = (init: RequestInit): RequestInit => ({ ...init, headers: { ...Object.fromEntries(new Headers(init.headers)), ...authorization(token()) } });

function problemIn(text: string, status: number, statusText: string, retryAfter: string | null = null): Problem {
  const seconds = retryAfter ? Number(retryAfter) : NaN;
  const again = seconds >= 0 ? seconds : null;
  try {
    return new Problem(JSON.parse(text) as ProblemBody, again);
  } catch {
    return new Problem({ type: "about:blank", title: statusText, status, detail: text.slice(0, 300) }, again);
  }
}

/** The answer where it is below 400; else throws a Problem. */
async function taken(answer: Response): Promise<Response> {
  if (answer.status === 401) needsToken.value = true;
  if (answer.status >= 400) throw problemIn(await answer.text(), answer.status, answer.statusText, answer.headers.get("Retry-After"));
  return answer;
}

function failed(failure: unknown): never {
  if (failure instanceof DOMException && failure.name === "AbortError") throw failure;
  throw new Unreachable("the daemon does not answer");
}

/**
 * An answer below 400. Throws Problem, or Unreachable where there was none; an abort stays an AbortError. What somebody
 * does goes before what is looked at.
 */
export async function ask(path: string, init: RequestInit = {}): Promise<Response> {
  const priority = init.method && init.method !== "GET" ? "high" : "auto";
  return taken(await fetch(path, { priority, ...withToken(init) }).catch(failed));
}

/** Rejects with an AbortError where it is stopped meanwhile. */
const pause = (seconds: number, stop: AbortSignal): Promise<void> =>
  new Promise((resolve, reject) => {
    const abort = () => {
      clearTimeout(timer);
      reject(new DOMException("stopped", "AbortError"));
    };
    const timer = setTimeout(() => {
      stop.removeEventListener("abort", abort);
      resolve();
    }, 1000 * seconds);
    if (stop.aborted) abort();
    else stop.addEventListener("abort", abort, { once: true });
  });

const again = (answer: Response): number | null => {
  const waits = answer.status === 503 || (answer.status === 202 && answer.headers.has("Preference-Applied"));
  const seconds = waits ? Number(answer.headers.get("Retry-After") ?? NaN) : NaN;
  return seconds >= 0 ? seconds : null;
};

/**
 * The answer to a GET that may take the daemon some time, as pictures do: few are asked for at once in all tabs
 * (slow_requests.ts), and again while the daemon says when to, until `enough` says that nobody wants it any more.
 */
export async function askPatiently(path: string, signal = new AbortController().signal, enough: () => boolean = () => false): Promise<Response> {
  for (;;) {
    const { body, ...head } = await askSlowly(path, signal).catch(failed);
    const answer = new Response(kWithoutBody.includes(head.status) ? null : body, head);
    const seconds = again(answer);
    if (seconds === null || enough()) return taken(answer);
    await pause(seconds, signal);
  }
}

type Query = Record<string, string | number | boolean | null | undefined>;

/** The path with the members of the query that say something. */
export function withQuery(path: string, query: Query = {}): string {
  const text = new URLSearchParams();
  for (const [name, value] of Object.entries(query))
    if (value !== undefined && value !== null && value !== "") text.set(name, String(value));
  return text.size ? `${path}?${text}` : path;
}

export async function getJson<T>(path: string, query: Query = {}, signal?: AbortSignal): Promise<T> {
  return (await (await ask(withQuery(path, query), signal ? { signal } : {})).json()) as T;
}

/** Sends JSON and reads JSON. A key makes it safe to send again: the daemon gives the same job for the same key. */
export async function sendJson<T>(method: "POST" | "PATCH" | "DELETE", path: string, body?: unknown, idempotencyKey?: string): Promise<T> {
  const headers: Record<string, string> = {};
  if (body !== undefined) headers["Content-Type"] = "application/json";
  if (idempotencyKey) headers["Idempotency-Key"] = idempotencyKey;
  const answer = await ask(path, { method, headers, ...(body === undefined ? {} : { body: JSON.stringify(body) }) });
  return (await answer.json()) as T;
}

/** Sends a file and reads JSON. */
export async function upload<T>(path: string, file: Blob | FormData, mediaType?: string): Promise<T> {
  const headers: Record<string, string> = mediaType ? { "Content-Type": mediaType } : {};
  return (await (await ask(path, { method: "POST", headers, body: file })).json()) as T;
}

/**
 * Sends a file and reads JSON and the status, telling the share of it that is sent. By XMLHttpRequest, since fetch() does
 * not tell how much of a body has gone.
 */
export function uploadTelling<T>(path: string, file: Blob | FormData, mediaType: string | null, tell: (share: number) => void, stop: AbortSignal): Promise<{ status: number; body: T }> {
  return new Promise((resolve, reject) => {
    const request = new XMLHttpRequest();
    request.open("POST", path);
    for (const [name, value] of Object.entries(authorization(token()))) request.setRequestHeader(name, value);
    if (mediaType) request.setRequestHeader("Content-Type", mediaType);
    request.upload.onprogress = (event) => event.lengthComputable && tell(event.loaded / event.total);
    request.upload.onload = () => tell(1);
    request.onerror = () => reject(new Unreachable("the daemon does not answer, or has ended the connection"));
    request.onabort = () => reject(new DOMException("stopped", "AbortError"));
    request.onload = () => {
      if (request.status === 401) needsToken.value = true;
      if (request.status >= 400) return reject(problemIn(request.responseText, request.status, request.statusText));
      resolve({ status: request.status, body: JSON.parse(request.responseText) as T });
    };
    stop.addEventListener("abort", () => request.abort());
    request.send(file);
  });
}

/** Saves what is at a path under a name; a plain link could not carry the token. */
export async function download(path: string, name: string): Promise<void> {
  saveBlob(await (await ask(path)).blob(), name);
}

export function saveBlob(blob: Blob, name: string): void {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(blob);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 60_000);
}
