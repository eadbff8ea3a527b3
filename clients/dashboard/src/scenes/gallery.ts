// Which scenes the gallery shows, and in which order.

import type { Scene } from "../api/types";

export const kOrders = { listed: "as listed", name: "by name", triangles: "most triangles first", bytes: "largest files first" } as const;
export type Order = keyof typeof kOrders;
export const isOrder = (text: string | undefined): text is Order => text !== undefined && text in kOrders;

/** The scenes with every word of the search in their name or id, in any order of words. */
export function found(scenes: Scene[], search: string): Scene[] {
  const words = search.toLowerCase().split(/\s+/).filter(Boolean);
  return scenes.filter((scene) => {
    const text = `${scene.name} ${scene.id}`.toLowerCase();
    return words.every((word) => text.includes(word));
  });
}

export function ordered(scenes: Scene[], order: Order): Scene[] {
  const compare: Record<Exclude<Order, "listed">, (a: Scene, b: Scene) => number> = {
    name: (a, b) => a.name.localeCompare(b.name, "en", { numeric: true }),
    triangles: (a, b) => (b.triangles ?? 0) - (a.triangles ?? 0),
    bytes: (a, b) => (b.bytes ?? 0) - (a.bytes ?? 0),
  };
  return order === "listed" ? scenes : [...scenes].sort(compare[order]);
}

const counted = (count: number, one: string, many = `${one}s`) => `${count.toLocaleString("en")} ${count === 1 ? one : many}`;

/** "32 triangles · 1 light · 4 materials" */
export function factsText(scene: Scene): string {
  const facts = [counted(scene.triangles ?? 0, "triangle")];
  if (scene.lights) {
    const lamps = scene.lights.punctual;
    const parts = [
      ...(scene.lights.area > 0 ? [counted(scene.lights.area, "glowing triangle")] : []),
      ...(lamps > 0 ? [counted(lamps, "lamp")] : []),
      ...(scene.lights.environment ? ["sky"] : []),
    ];
    facts.push(parts.join(", ") || "no light");
  }
  facts.push(counted(scene.materials ?? 0, "material"));
  return facts.join(" · ");
}
