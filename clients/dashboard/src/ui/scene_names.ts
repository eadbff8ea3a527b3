// Names of uploaded scenes, which jobs and studies name by the hash of their content.

import { signal } from "@preact/signals";

import { getJson } from "../api/client";
import type { Page, Scene } from "../api/types";

const names = signal<ReadonlyMap<string, string>>(new Map());
const asked = new Set<string>();
let asking = false;

const isHash = (id: string): boolean => /^[0-9a-f]{16,}$/.test(id);

async function load(): Promise<void> {
  asking = true;
  try {
    const { items } = await getJson<Page<Scene>>("/v1/scenes", { limit: 1000 });
    names.value = new Map(items.map((scene) => [scene.id, scene.name]));
  } catch {
    asked.clear(); // the daemon does not answer: asked again with the next drawing
  }
  asking = false;
}

/** The scene's name; of one that has been removed, or has none, the beginning of its hash. */
export function sceneName(id: string): string {
  const known = names.value.get(id);
  if (known) return known;
  if (!isHash(id)) return id;
  if (!asking && !asked.has(id)) {
    asked.add(id);
    void load();
  }
  return id.slice(0, 10);
}
