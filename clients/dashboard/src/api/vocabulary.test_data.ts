// Some of the daemon's layers, for tests without a daemon.

import type { Layer } from "./types";

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
