// What the usual errors are, in a few words (renderer/error/metric.h has them all).

export const kMetricTexts: readonly [string, string][] = [
  ["relative_mse", "squared error over the square of the reference; the usual measure of noise"],
  ["flip_hdr", "how different it looks, 0 to 1 (HDR-FLIP)"],
  ["rmse", "root of the mean squared difference"],
  ["smape", "difference over the sum, robust against bright pixels"],
  ["rmse_8bit", "at 8-bit sRGB, as papers of that time have it"],
  ["estimated_relative_mse", "estimated from the passes; needs no reference"],
];

/** Of an error by its name, also of one layer ("indirect:relative_mse"); empty for one that is rarely asked for. */
export function metricText(metric: string): string {
  const [layer, name] = metric.includes(":") ? metric.split(":", 2) : ["", metric];
  const text = kMetricTexts.find(([known]) => known === name)?.[1] ?? "";
  return text && layer ? `of the ${layer} light: ${text}` : text;
}
