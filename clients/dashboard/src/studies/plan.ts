// A comparison being planned: what the form holds, and the request it becomes. All of it is plain data, kept in the
// session so that a reload loses nothing.

import type { ComparisonRequest, Fault, Json, Method, MethodChoice, Reference, StopConditions } from "../api/types";
import { valueOfText } from "../ui/parameter_form";
import { kManyBounces } from "./bounces";

export interface SweepPlan {
  parameter: string;
  /** As typed: "1000, 5000, 25000". */
  values: string;
}

export interface EntryPlan {
  /** Of this entry alone, for as long as the plan lives. */
  key: number;
  label: string;
  method: MethodChoice;
  sweeps: SweepPlan[];
}

export type ReferencePlan =
  | { kind: "render"; method: MethodChoice; passes: number }
  | { kind: "given"; source: string }
  | { kind: "none" };

export interface Plan {
  scene: string;
  width: number;
  height: number;
  entries: EntryPlan[];
  stop: StopConditions;
  reference: ReferencePlan;
  metrics: string[];
  /** As typed: "1, 2, 3". */
  seeds: string;
  /** What a repeated comparison had and this form does not show. */
  more: Record<string, unknown>;
}

let lastKey = 0;
export const nextKey = (): number => ++lastKey;

export const entryOf = (method: MethodChoice, label = "", sweeps: SweepPlan[] = []): EntryPlan => ({ key: nextKey(), label, method, sweeps });

/** Words around commas or spaces, empty ones left out. */
const listOf = (text: string): string[] => text.split(/[,;\s]+/).filter(Boolean);

/** What a list of a sweep or of seeds means: numbers, true and false where they are such, else the words themselves. */
export const valuesOf = (text: string): Json[] =>
  listOf(text).map((word) => (word === "true" ? true : word === "false" ? false : (valueOfText(word) ?? word)));

function referenceOf(plan: Plan): Reference | null {
  switch (plan.reference.kind) {
    case "render":
      return { method: plan.reference.method, stop: { passes: plan.reference.passes } };
    case "given":
      return plan.reference.source.trim();
    case "none":
      return null;
  }
}

/** Labels must differ: an entry without one of its own is called by its method, and numbered where that is taken. */
export function labelsOf(plan: Plan, methods: Method[]): string[] {
  const taken = new Set<string>();
  return plan.entries.map((entry) => {
    const title = methods.find((method) => method.name === entry.method.name)?.title ?? entry.method.name;
    const wanted = entry.label.trim() || title.toLowerCase();
    let label = wanted;
    for (let number = 2; !entry.label.trim() && taken.has(label); ++number) label = `${wanted} ${number}`;
    taken.add(label);
    return label;
  });
}

const sweepOf = (sweeps: SweepPlan[]): Record<string, Json[]> =>
  Object.fromEntries(sweeps.filter((sweep) => sweep.parameter).map((sweep) => [sweep.parameter, valuesOf(sweep.values)]));

export function requestOf(plan: Plan, methods: Method[]): ComparisonRequest {
  const labels = labelsOf(plan, methods);
  return {
    ...plan.more,
    scene: plan.scene,
    image: { ...(plan.more.image as object | undefined), width: plan.width, height: plan.height },
    reference: referenceOf(plan),
    entries: plan.entries.map((entry, i) => {
      const sweep = sweepOf(entry.sweeps);
      return { label: labels[i]!, method: entry.method, ...(Object.keys(sweep).length ? { sweep } : {}) };
    }),
    stop: Object.fromEntries(Object.entries(plan.stop).filter(([, value]) => value !== null && value !== undefined)),
    metrics: plan.metrics,
    seeds: valuesOf(plan.seeds) as number[],
  };
}

const sweepsOf = (sweep: Record<string, Json[]> | null | undefined): SweepPlan[] =>
  Object.entries(sweep ?? {}).map(([parameter, values]) => ({ parameter, values: values.map((value) => String(value)).join(", ") }));

/** The plan that a request came from, or could have. */
export function planOf(request: ComparisonRequest): Plan {
  // What is said of one is not said of another.
  const { scene, image, reference, entries, stop, metrics, seeds, title: _title, notes: _notes, ...more } = request;
  const { width, height, ...aboutImage } = image;
  return {
    scene,
    width,
    height,
    entries: entries.map((entry) => entryOf(entry.method, entry.label ?? "", sweepsOf(entry.sweep))),
    stop: Object.fromEntries(Object.entries(stop).filter(([, value]) => value !== null)),
    reference: !reference
      ? { kind: "none" }
      : typeof reference === "string"
        ? { kind: "given", source: reference }
        : { kind: "render", method: reference.method, passes: reference.stop.passes ?? kReferencePasses },
    metrics: metrics ?? ["relative_mse"],
    seeds: (seeds ?? [1]).join(", "),
    more: { ...Object.fromEntries(Object.entries(more).filter(([, value]) => value !== null)), ...(Object.keys(aboutImage).length ? { image: aboutImage } : {}) },
  };
}

// -- presets ------------------------------------------------------------------------------------------------------------

const kReferencePasses = 1024;

export interface Preset {
  id: string;
  name: string;
  text: string;
  entries: () => EntryPlan[];
  /** What renders the reference; path tracing without end of bounces where nothing is said. */
  reference?: MethodChoice;
}

const cpu = (name: string, parameters = {}): MethodChoice => ({ name, device: "cpu", parameters });

export const kPresets: Preset[] = [
  {
    id: "three-methods",
    name: "Three methods",
    text: `Path tracing, photon mapping and photon splatting, ${kManyBounces} bounces of indirect light each`,
    entries: () => [
      entryOf(cpu("path_tracing", { indirect_bounces: kManyBounces })),
      entryOf(cpu("photon_mapping", { indirect_bounces: kManyBounces })),
      entryOf(cpu("photon_splatting", { bounces: kManyBounces })),
    ],
    reference: cpu("path_tracing", { indirect_bounces: kManyBounces }),
  },
  {
    id: "paths-photons",
    name: "Paths against photons",
    text: "Path tracing against photon mapping",
    entries: () => [entryOf(cpu("path_tracing")), entryOf(cpu("photon_mapping"))],
  },
  {
    id: "photon-counts",
    name: "How many photons",
    text: "Photon mapping at three numbers of photons a pass",
    entries: () => [entryOf(cpu("photon_mapping"), "photon mapping", [{ parameter: "photons", values: "20000, 100000, 500000" }])],
  },
  {
    id: "gathering",
    name: "Final gathering or not",
    text: "Photon mapping with final gathering, and its map seen directly",
    entries: () => [entryOf(cpu("photon_mapping"), "final gathering"), entryOf(cpu("photon_mapping", { gather: "direct" }), "map seen directly")],
  },
];

/** The plan with a preset's entries, and the reference that goes with them where one is to be rendered. */
export function withPreset(plan: Plan, preset: Preset): Plan {
  const { reference } = plan;
  const method = preset.reference ?? cpu("path_tracing");
  return { ...plan, entries: preset.entries(), reference: reference.kind === "render" ? { ...reference, method } : reference };
}

export const kDefaultScene = "cornell-box";

export const defaultPlan = (scene = kDefaultScene): Plan =>
  withPreset(
    {
      scene,
      width: 256,
      height: 256,
      entries: [],
      stop: { seconds: 10 },
      reference: { kind: "render", method: cpu("path_tracing"), passes: kReferencePasses },
      metrics: ["relative_mse", "flip_hdr"],
      seeds: "1",
      more: {},
    },
    kPresets[0]!,
  );

// -- the session --------------------------------------------------------------------------------------------------------

/** A plan as the session kept it; null where there is none that can be read. */
export function readPlan(text: string | null): Plan | null {
  if (!text) return null;
  try {
    const plan = JSON.parse(text) as Plan;
    if (typeof plan.scene !== "string" || !Array.isArray(plan.entries) || typeof plan.seeds !== "string") return null;
    return { ...plan, entries: plan.entries.map((entry) => ({ ...entry, key: nextKey() })) };
  } catch {
    return null;
  }
}

// -- faults -------------------------------------------------------------------------------------------------------------

/** Those at a pointer or beneath it, with their pointers from there. */
export const faultsUnder = (faults: Fault[], pointer: string): Fault[] =>
  faults
    .filter((fault) => fault.pointer === pointer || fault.pointer.startsWith(`${pointer}/`))
    .map((fault) => ({ ...fault, pointer: fault.pointer.slice(pointer.length) }));

/** A part of a JSON pointer as it is written in one (RFC 6901). */
export const pointerToken = (name: string): string => name.replaceAll("~", "~0").replaceAll("/", "~1");
