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

/** "32 triangles, 4 materials, area lights" */
export function factsText(scene: Scene): string {
  const { lights } = scene;
  const lit = lights
    ? [...(lights.area > 0 ? ["area lights"] : []), ...(lights.punctual > 0 ? [counted(lights.punctual, "lamp")] : []), ...(lights.environment ? ["a sky"] : [])]
    : [];
  return [counted(scene.triangles ?? 0, "triangle"), counted(scene.materials ?? 0, "material"), lit.join(" and ") || "no light"].join(", ");
}
