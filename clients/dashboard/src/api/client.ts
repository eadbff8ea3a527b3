// Requests to the daemon: the token of who looks, and its problems as errors that name every fault.

import { signal } from "@preact/signals";

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

const kTokenKey = "photond.token";

/** True once the daemon has asked for a token that it knows: the shell then shows the sign-in. */
export const needsToken = signal(false);

export function signIn(token: string): void {
  sessionStorage.setItem(kTokenKey, token);
  needsToken.value = false;
}

export const hasToken = (): boolean => sessionStorage.getItem(kTokenKey) !== null;

const authorization = (): Record<string, string> => {
  const token = sessionStorage.getItem(kTokenKey);
  return token ? { Authorization: `Bearer ${token}` } : {};
};

function withToken(init: RequestInit): RequestInit {
  const headers = new Headers(init.headers);
  for (const [name, value] of Object.entries(authorization())) headers.set(name, value);
  return { ...init, headers };
}

function problemIn(text: string, status: number, statusText: string, retryAfter: string | null = null): Problem {
  const seconds = retryAfter ? Number(retryAfter) : NaN;
  const again = seconds >= 0 ? seconds : null;
  try {
    return new Problem(JSON.parse(text) as ProblemBody, again);
  } catch {
    return new Problem({ type: "about:blank", title: statusText, status, detail: text.slice(0, 300) }, again);
  }
}

/** An answer below 400. Throws Problem, or Unreachable where there was none; an abort stays an AbortError. */
export async function ask(path: string, init: RequestInit = {}): Promise<Response> {
  let answer: Response;
  try {
    answer = await fetch(path, withToken(init));
  } catch (failure) {
    if (failure instanceof DOMException && failure.name === "AbortError") throw failure;
    throw new Unreachable("the daemon does not answer");
  }
  if (answer.status === 401) needsToken.value = true;
  if (answer.status >= 400) throw problemIn(await answer.text(), answer.status, answer.statusText, answer.headers.get("Retry-After"));
  return answer;
}

/** Rejects with an AbortError where it is stopped meanwhile. */
const pause = (seconds: number, stop?: AbortSignal | null): Promise<void> =>
  new Promise((resolve, reject) => {
    const abort = () => {
      clearTimeout(timer);
      reject(new DOMException("stopped", "AbortError"));
    };
    const timer = setTimeout(() => {
      stop?.removeEventListener("abort", abort);
      resolve();
    }, 1000 * seconds);
    if (stop?.aborted) abort();
    else stop?.addEventListener("abort", abort, { once: true });
  });

/**
 * The same, asked again while the daemon says when to (503: pictures wait while a job renders), until `enough` says that
 * nobody wants it any more.
 */
export async function askPatiently(path: string, init: RequestInit = {}, enough: () => boolean = () => false): Promise<Response> {
  for (;;) {
    try {
      return await ask(path, init);
    } catch (failure) {
      if (!(failure instanceof Problem) || failure.status !== 503 || failure.retryAfterSeconds === null || enough()) throw failure;
      await pause(failure.retryAfterSeconds, init.signal);
    }
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
    for (const [name, value] of Object.entries(authorization())) request.setRequestHeader(name, value);
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
