// What a job's statistics say of its errors, and in which words it was measured.

import type { NoiseInterval, ReferenceFacts, Statistics } from "../api/types";
import { plainName } from "../ui/format";

export interface Measured {
  name: string;
  value: number | null;
  interval: NoiseInterval | null;
  /** What the reference's own noise explains, where it has a part. */
  own: number | null;
}

/** What the numbers of a metric that has several are (renderer/error/metric.h): one a channel, or percentiles. */
const kParts: Record<number, string[]> = { 3: ["R", "G", "B"], 4: ["50 %", "90 %", "99 %", "greatest"] };

/** Metrics that are one number; of those that are several, each. */
function partsOf(error: Record<string, unknown>, intervals: Record<string, unknown>, own: Record<string, unknown>, prefix = ""): Measured[] {
  return Object.entries(error).flatMap(([name, value]): Measured[] => {
    if (value === null || typeof value === "number") {
      const interval = (intervals[name] ?? null) as NoiseInterval | null;
      return [{ name: prefix + plainName(name), value, interval, own: interval ? null : ((own[name] ?? null) as number | null) }];
    }
    const parts = Array.isArray(value) ? Object.fromEntries(value.map((part: unknown, i) => [kParts[value.length]?.[i] ?? String(i + 1), part])) : value;
    return typeof parts === "object" ? partsOf(parts as Record<string, unknown>, {}, {}, `${prefix}${plainName(name)} `) : [];
  });
}

export const measuredOf = ({ error, error_interval: intervals, reference_error: own }: Statistics): Measured[] => partsOf(error ?? {}, intervals ?? {}, own ?? {});

/** Whether the references' noise has a part in the errors, in a sentence; empty where nothing says how it was measured. */
export function measuringText(reference: ReferenceFacts | null | undefined, noiseKnown: boolean): string {
  const passes = reference?.passes ? ` of ${reference.passes.toLocaleString("en")} passes` : "";
  const share = noiseKnown ? "its noise is a part of every error, as far as it is known in the last column" : "its noise is a part of every error, and not known";
  switch (reference?.form) {
    case "two_films": {
      const level = reference.confidence ? ` at ${Math.round(100 * reference.confidence)} %` : "";
      const neighbours = Object.values(reference.denominators ?? {}).includes("neighbours") ? "; relative errors are relative to a pixel's neighbours in the reference, whose own pixels are too noisy for that" : "";
      return `Measured against two films of different seeds, whose noise drops out of mean squares; in brackets what it leaves open${level}${neighbours}.`;
    }
    case "image":
      return `Measured against one image: ${share}.`;
    case "film":
      return `Measured against one film${passes}: ${share}.`;
    default:
      return reference ? `Measured against one reference${passes}: ${share}.` : "";
  }
}
