// How many bounces of indirect light each side of a comparison goes on for. A method that stops sooner than its reference
// keeps the light of the later bounces as its error, however long it renders: a fair comparison gives all the same number.

import type { ComparisonRequest, Method, MethodChoice } from "../api/types";

/** Light-transport methods call it one, image-space and many-light methods the other. */
const kNames = ["indirect_bounces", "bounces"] as const;

/** As many as leave next to nothing over in rooms as bright as most. */
export const kManyBounces = 6;

/** Methods that count them do no more than these, which are as good as all. */
const kAllBounces = 254;

/** Infinity where there is no end to them; null of a method that has no such parameter, or is not known. */
export function bouncesOf(choice: MethodChoice, methods: Method[] = []): number | null {
  const schemas = methods.find((method) => method.name === choice.name)?.parameters.properties ?? {};
  for (const name of kNames) {
    const given = choice.parameters?.[name];
    const value = given === undefined ? schemas[name]?.default : given;
    if (typeof value === "number") return value < kAllBounces ? value : Infinity;
    if (value === null) return Infinity;
  }
  return null;
}

/** The method with so many bounces, or with as many as it can do. */
export function withBounces(choice: MethodChoice, bounces: number, methods: Method[]): MethodChoice {
  const schemas = methods.find((method) => method.name === choice.name)?.parameters.properties ?? {};
  const name = kNames.find((known) => known in schemas);
  if (!name) return choice;
  return { ...choice, parameters: { ...choice.parameters, [name]: Math.min(bounces, schemas[name]!.maximum ?? bounces) } };
}

const bouncesText = (bounces: number): string => (bounces === Infinity ? "without end" : bounces === 1 ? "for 1 bounce" : `for ${bounces} bounces`);

/** A sentence for each entry that goes on for another number of bounces than the reference; none where that is not known. */
export function unequalBounces(request: Pick<ComparisonRequest, "entries" | "reference">, methods: Method[] = []): string[] {
  if (!request.reference || typeof request.reference === "string") return [];
  const truth = bouncesOf(request.reference.method, methods);
  if (truth === null) return [];
  return request.entries.flatMap((entry) => {
    const own = bouncesOf(entry.method, methods);
    if (own === null || own === truth || kNames.some((name) => entry.sweep?.[name])) return [];
    return [`${entry.label ?? entry.method.name} follows indirect light ${bouncesText(own)}, the reference ${bouncesText(truth)}.`];
  });
}
