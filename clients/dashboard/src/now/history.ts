// The last minutes of the daemon's status events, gathered from when the page was opened, whichever room is shown.

import { signal } from "@preact/signals";

import { listen } from "../api/events";
import { type Sample, sampleOf, withSample } from "./rates";

export const samples = signal<Sample[]>([]);

listen((event) => {
  if (event.type === "status") samples.value = withSample(samples.peek(), sampleOf(event.status));
});
