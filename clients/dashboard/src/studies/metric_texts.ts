// What the usual errors are, in a few words.

import { metrics } from "../api/vocabulary";

export const usualMetrics = (): { name: string; line: string }[] =>
  metrics.value.flatMap(({ name, line }) => (line === null ? [] : [{ name, line }]));

/** Of an error by its name, also of one layer ("indirect:relative_mse"); empty for one that is rarely asked for. */
export function metricText(metric: string): string {
  const [layer, name] = metric.includes(":") ? metric.split(":", 2) : ["", metric];
  const text = usualMetrics().find((usual) => usual.name === name)?.line ?? "";
  return text && layer ? `of the ${layer} light: ${text}` : text;
}
