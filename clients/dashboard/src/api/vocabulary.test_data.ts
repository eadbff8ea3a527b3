// Some of the daemon's layers and error measures, for tests without a daemon.

import type { Layer, Metric } from "./types";

const layer = (name: string, channels: string, more: Partial<Layer> = {}): Layer => ({
  name, channels, always: false, measured: false, preview: null, exposure: false, unit: "", description: "", ...more,
});
const light: Partial<Layer> = { always: true, measured: true, preview: "light", exposure: true, unit: "W m^-2 sr^-1" };

export const someLayers: Layer[] = [
  layer("beauty", "RGB", light),
  layer("emitted", "RGB", light),
  layer("direct", "RGB", light),
  layer("indirect", "RGB", light),
  layer("normal", "XYZ"),
  layer("position", "XYZ", { unit: "m" }),
  layer("depth", "Z", { unit: "m" }),
  layer("photon_count", "Y"),
  layer("overlap", "Y", { preview: "heat_map" }),
];

const metric = (name: string, slope: number | null): Metric => ({
  name, title: name, values: 1, needs_reference: true, on_request: false, slope, description: "", line: null,
});

export const someMetrics: Metric[] = [metric("relative_mse", -1), metric("rmse", -0.5), metric("smape", null), metric("flip_hdr", null)];
