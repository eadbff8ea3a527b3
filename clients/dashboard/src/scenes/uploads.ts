// Scenes on their way to the daemon; they go on whichever room is shown.

import { signal } from "@preact/signals";

import { Problem, uploadTelling, withQuery } from "../api/client";
import type { Fault, Scene } from "../api/types";
import { bodyOf, type DroppedFile, type Package, packed } from "./packing";

export interface Upload {
  id: number;
  name: string;
  bytes: number;
  /** Of the bytes, those the daemon has; at 1 it reads the scene. */
  sent: number;
  /** What has become of it. */
  scene?: Scene;
  known?: boolean;
  failure?: string;
  faults?: Fault[];
  stop?: () => void;
}

export const uploads = signal<Upload[]>([]);
/** Counts the scenes that have arrived. */
export const arrivals = signal(0);
let next = 0;

function change(id: number, members: Partial<Upload>): void {
  uploads.value = uploads.value.map((upload) => (upload.id === id ? { ...upload, ...members } : upload));
}

export function dismiss(id: number): void {
  uploads.value = uploads.value.filter((upload) => upload.id !== id);
}

async function send(scene: Package): Promise<void> {
  const id = ++next;
  const stopper = new AbortController();
  uploads.value = [...uploads.value, { id, name: scene.name, bytes: scene.bytes, sent: 0, stop: () => stopper.abort() }];
  const { body, mediaType } = bodyOf(scene);
  try {
    const path = withQuery("/v1/scenes", { name: scene.name });
    const answer = await uploadTelling<Scene>(path, body, mediaType, (sent) => change(id, { sent }), stopper.signal);
    change(id, { scene: answer.body, known: answer.status === 200, sent: 1 });
    ++arrivals.value;
  } catch (failure) {
    if (stopper.signal.aborted) return dismiss(id);
    change(id, {
      failure: failure instanceof Error ? failure.message : String(failure),
      faults: failure instanceof Problem ? failure.faults : [],
    });
  }
}

/** Sends what was dropped, one scene after another. */
export async function sendAll(dropped: DroppedFile[]): Promise<void> {
  const { packages, faults } = packed(dropped);
  for (const failure of faults) uploads.value = [...uploads.value, { id: ++next, name: "", bytes: 0, sent: 0, failure }];
  for (const scene of packages) await send(scene);
}
