// What the images are: jobs and uploaded files, with their names, sizes and layers.

import { getJson } from "../api/client";
import { isOver, type ImageInfo, type Job } from "../api/types";
import { alwaysLayers } from "../api/vocabulary";
import { plainName, secondsText, sizeText } from "../ui/format";
import { pathOfSource } from "./pixels";

export interface Source {
  name: string;
  title: string;
  detail: string;
  /** Null while it is asked for. */
  size: { width: number; height: number } | null;
  layers: string[];
  job: Job | null;
  failure: Error | null;
  /** Rises when there is something newer to be seen. */
  version: number;
}

const kNamesKey = "photond.image-names";

function rememberedNames(): Record<string, string> {
  try {
    return JSON.parse(localStorage.getItem(kNamesKey) ?? "{}") as Record<string, string>;
  } catch {
    return {};
  }
}

/** What a file was called that was uploaded from here; the daemon knows images by their content alone. */
export const nameOfImage = (id: string): string => rememberedNames()[id] ?? `image ${id.slice(0, 10)}`;

export function rememberName(id: string, name: string): void {
  const names = Object.entries(rememberedNames()).filter(([other]) => other !== id);
  localStorage.setItem(kNamesKey, JSON.stringify(Object.fromEntries([...names.slice(-99), [id, name]])));
}

export const unknownSource = (name: string): Source => ({
  name,
  title: name.startsWith("job:") ? name.slice(4) : nameOfImage(name.slice(6)),
  detail: "",
  size: null,
  layers: [],
  job: null,
  failure: null,
  version: 0,
});

export const passesText = (passes: number): string => (passes === 1 ? "1 pass" : `${passes.toLocaleString("en")} passes`);

/** What tells a job from others of the same scene, in a line. */
export function jobDetail(job: Job): string {
  const parts = [passesText(job.passes_done), secondsText(job.seconds), sizeText(job.request.image)];
  return `${isOver(job.state) ? "" : `${job.state}, `}${parts.join(", ")}`;
}

export function sourceOfJob(job: Job, version = 0): Source {
  const label = Object.values(job.request.labels ?? {})[0];
  return {
    name: `job:${job.id}`,
    title: `${job.id} ${plainName(job.request.method.name)}${label ? `, ${label}` : ""}${job.role === "reference" ? " (reference)" : ""}`,
    detail: jobDetail(job),
    size: { width: job.request.image.width, height: job.request.image.height },
    layers: [...new Set([...alwaysLayers(), ...(job.request.layers ?? [])])],
    job,
    failure: null,
    version,
  };
}

export async function fetchSource(name: string, signal: AbortSignal): Promise<Source> {
  if (name.startsWith("job:")) return sourceOfJob(await getJson<Job>(pathOfSource(name), {}, signal));
  const image = await getJson<ImageInfo>(pathOfSource(name), {}, signal);
  return {
    ...unknownSource(name),
    detail: sizeText(image),
    size: { width: image.width, height: image.height },
    layers: image.layers.map((layer) => layer.name),
  };
}

/** Both films of a reference, where it is one of two that some job here is measured against; else null. */
export function filmsOf(reference: string, sources: ReadonlyMap<string, Source>): [string, string] | null {
  for (const { job } of sources.values()) {
    const films = job?.reference_jobs?.map((id) => `job:${id}`) ?? [];
    if (films.length === 2 && films.includes(reference)) return films as [string, string];
  }
  return null;
}

/** The source that a job is measured against while it renders. */
export function referenceOf(job: Job): string | null {
  if (job.reference_job) return `job:${job.reference_job}`;
  return typeof job.request.reference === "string" ? job.request.reference : null;
}

/** Which image the others are measured against where nobody has said: the one that their jobs are, or the first. */
export function usualReference(images: string[], sources: ReadonlyMap<string, Source>): number {
  const jobs = images.map((name) => sources.get(name)?.job ?? null);
  const named = images.findIndex((name) => jobs.some((job) => job && referenceOf(job) === name));
  if (named >= 0) return named;
  return Math.max(0, jobs.findIndex((job) => job?.role === "reference"));
}

export interface LayerChoice {
  name: string;
  /** Numbers of images that have it, from 0. */
  of: number[];
}

/** The layers of all images, those that most have in the order of the first. */
export function layerChoices(images: string[], sources: ReadonlyMap<string, Source>): LayerChoice[] {
  const choices = new Map<string, number[]>();
  images.forEach((name, index) => sources.get(name)?.layers.forEach((layer) => choices.set(layer, [...(choices.get(layer) ?? []), index])));
  return [...choices].map(([name, of]) => ({ name, of }));
}
