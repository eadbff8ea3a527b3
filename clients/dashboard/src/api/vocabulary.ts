// What the daemon knows by name, as it says it itself: layers of images and error measures. Asked for once, before the first
// room shows (main.tsx).

import { effect, signal } from "@preact/signals";

import { getJson } from "./client";
import { connection } from "./events";
import type { Layer, Metric, Page } from "./types";

export const layers = signal<readonly Layer[]>([]);
export const metrics = signal<readonly Metric[]>([]);

const kPatience = 3000; // ms: a page without these names is better than none

async function load(): Promise<void> {
  const stop = AbortSignal.timeout(kPatience);
  const all = await Promise.all([getJson<Page<Layer>>("/v1/layers", {}, stop), getJson<Page<Metric>>("/v1/metrics", {}, stop)]);
  layers.value = all[0].items;
  metrics.value = all[1].items;
}

/** Ends when the names are there, or cannot be had; then they are asked for again once the daemon answers. */
export async function startVocabulary(): Promise<void> {
  await load().catch(() =>
    effect(() => {
      if (connection.value === "live" && layers.peek().length === 0) load().catch(() => undefined);
    }),
  );
}

export const layerNamed = (name: string): Layer | undefined => layers.value.find((layer) => layer.name === name);

/** Of every image, the beauty first. */
export const alwaysLayers = (): string[] => layers.value.filter((layer) => layer.always).map(({ name }) => name);

/** Whether it is a part of the light: the daemon measures those, and FLIP is of them only. */
export const isMeasured = (layer: string): boolean => layerNamed(layer)?.measured ?? false;

/** Of a measure, or of one of a layer ("indirect:rmse"). */
export const metricNamed = (name: string): Metric | undefined => {
  const plain = name.slice(name.indexOf(":") + 1);
  return metrics.value.find((metric) => metric.name === plain);
};

/** Measures that are one number, so that a target may name them; without a reference those estimated from the passes. */
export const targetMetrics = (withReference: boolean): string[] =>
  metrics.value.filter((metric) => metric.values === 1 && (withReference || !metric.needs_reference)).map(({ name }) => name);
