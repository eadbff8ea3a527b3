// What lies on the desk: the images of the address, their pixels as they come, and from both what each pane shows.

import { computed, effect, signal, type ReadonlySignal } from "@preact/signals";

import { listen, type StreamEvent } from "../api/events";
import { isOver, type Job } from "../api/types";
import { isMeasured } from "../api/vocabulary";
import type { Developer, Picture } from "./gl_develop";
import { besideOf, kStart, type Look } from "./look";
import { paintOf, type Ground, type Paint } from "./paint";
import { PixelStore, type Entry, type Wanted } from "./pixel_store";
import { fetchFlip, fetchLayer, type PixelImage } from "./pixels";
import { fetchSource, layerChoices, referenceOf, sourceOfJob, unknownSource, usualReference, type Source } from "./sources";
import { fitted, gridOf, type Box, type Point, type Size, type View } from "./view";

export interface Pane {
  index: number;
  box: Box;
  clip: Box;
}

/** What is to be seen of an image: a picture, or why there is none. */
export interface Shown {
  picture: Picture | null;
  /** The daemon is asked for it. */
  busy: boolean;
  note: string | null;
}

/** The least time between two looks at a job that runs. */
const kLiveMs = 2000;

export class Desk {
  readonly look = signal<Look>(kStart);
  readonly sources = signal<ReadonlyMap<string, Source>>(new Map());
  readonly store = new PixelStore();
  /** Of the stage, in device pixels. */
  readonly stage = signal<Size>({ width: 1, height: 1 });
  readonly density = signal(1);
  /** The pixel under the pointer. */
  readonly hovered = signal<Point | null>(null);
  readonly cursorOn = signal(false);
  readonly cropping = signal(false);
  /** Whether jobs that run are looked at again as they go on. */
  readonly live = signal(true);
  readonly developer = signal<Developer | null>(null);
  private parts = new Map<keyof Look, ReadonlySignal<unknown>>();
  private lastLook = new Map<string, number>();
  private timers = new Map<string, ReturnType<typeof setTimeout>>();
  private stops: (() => void)[] = [];
  private asked = new Map<string, AbortController>();

  /** One member of the look, which changes only when it does. */
  part<Name extends keyof Look>(name: Name): ReadonlySignal<Look[Name]> {
    let part = this.parts.get(name);
    if (!part) this.parts.set(name, (part = computed(() => this.look.value[name])));
    return part as ReadonlySignal<Look[Name]>;
  }

  change(members: Partial<Look>): void {
    this.look.value = { ...this.look.peek(), ...members };
  }

  start(): () => void {
    this.stops = [
      effect(() => this.askForSources(this.part("images").value)),
      effect(() => this.store.want(this.wanted.value)),
      effect(() => this.developer.value?.retain(this.held.value)),
      listen((event) => this.hear(event)),
    ];
    return () => {
      for (const stop of this.stops) stop();
      for (const stop of this.asked.values()) stop.abort();
      for (const timer of this.timers.values()) clearTimeout(timer);
      this.asked.clear();
      this.store.close();
    };
  }

  // --- What the images are

  private setSource(source: Source): void {
    this.sources.value = new Map(this.sources.peek()).set(source.name, source);
  }

  private askForSources(images: string[]): void {
    for (const name of images) {
      if (this.asked.has(name)) continue;
      const stop = new AbortController();
      this.asked.set(name, stop);
      this.setSource(unknownSource(name));
      fetchSource(name, stop.signal).then(
        (source) => this.setSource(source),
        (failure: Error) => {
          if (!stop.signal.aborted) this.setSource({ ...unknownSource(name), failure });
        },
      );
    }
  }

  private hear(event: StreamEvent): void {
    if (event.type === "status" || event.type === "curve") return;
    if (event.type === "gap") {
      for (const source of this.sources.peek().values()) if (source.job && !isOver(source.job.state)) this.refresh(source.name);
      return;
    }
    const name = `job:${event.change.id}`;
    const source = this.sources.peek().get(name);
    if (!source?.job) return;
    const { id, ...members } = event.change;
    const job: Job = { ...source.job, ...members, request: source.job.request, id };
    this.setSource(sourceOfJob(job, source.version));
    if (event.type === "state" && isOver(job.state)) this.refresh(name);
    else if (event.type === "progress" && this.live.peek()) this.refreshSoon(name);
  }

  private refreshSoon(name: string): void {
    if (this.timers.has(name)) return;
    const due = (this.lastLook.get(name) ?? 0) + kLiveMs - Date.now();
    this.timers.set(
      name,
      setTimeout(() => {
        this.timers.delete(name);
        this.refresh(name);
      }, Math.max(0, due)),
    );
  }

  /** Looks at a job again; what is shown stays until there is something newer. */
  refresh(name: string): void {
    const source = this.sources.peek().get(name);
    if (!source) return;
    this.lastLook.set(name, Date.now());
    this.setSource({ ...source, version: source.version + 1 });
  }

  /** Asks again for what failed, and for what may have gone on. */
  refreshAll(): void {
    for (const source of this.sources.peek().values()) {
      if (source.failure) this.asked.delete(source.name);
      else this.refresh(source.name);
    }
    this.askForSources(this.look.peek().images);
  }

  readonly running = computed(() => this.part("images").value.some((name) => {
    const job = this.sources.value.get(name)?.job;
    return job && !isOver(job.state);
  }));

  readonly reference = computed(() => {
    const images = this.part("images").value;
    const chosen = this.part("reference").value;
    return chosen && images.includes(chosen) ? images.indexOf(chosen) : usualReference(images, this.sources.value);
  });
  /** What images here were measured against and that is not here itself. */
  readonly referencesElsewhere = computed(() => {
    const images = this.part("images").value;
    const jobs = images.flatMap((name) => this.sources.value.get(name)?.job ?? []);
    return [...new Set(jobs.flatMap((job) => referenceOf(job) ?? []))].filter((name) => !images.includes(name));
  });
  readonly beside = computed(() => besideOf(this.look.value, this.reference.value));
  readonly layers = computed(() => layerChoices(this.part("images").value, this.sources.value));

  // --- Pixels

  private key = (name: string) => `${name} ${this.part("layer").value} ${this.part("precision").value}`;
  private flipKey = (name: string, reference: string) => `flip ${name} ${reference} ${this.part("layer").value} ${this.part("error").value}`;

  private readonly wanted = computed((): Wanted[] => {
    const images = this.part("images").value;
    const layer = this.part("layer").value;
    const precision = this.part("precision").value;
    const error = this.part("error").value;
    const sources = this.sources.value;
    const shown = this.part("shown").value;
    const against = images[this.reference.value];
    // What is looked at comes first.
    const inTurn = [...new Set([images[shown], against, ...images])].filter((name): name is string => name !== undefined);
    const ready = inTurn.flatMap((name) => sources.get(name) ?? []).filter((source) => source.layers.includes(layer));
    const wanted: Wanted[] = ready.map((source) => ({
      key: this.key(source.name),
      version: source.version,
      fetch: (signal) => fetchLayer(source.name, layer, precision, signal),
    }));
    const reference = ready.find((source) => source.name === against);
    if (!reference || !error.startsWith("flip") || !isMeasured(layer)) return wanted;
    for (const source of ready)
      if (source !== reference && sameSize(source.size, reference.size))
        wanted.push({
          key: this.flipKey(source.name, reference.name),
          version: source.version + reference.version,
          fetch: (signal) => fetchFlip(source.name, reference.name, layer, error === "flip_ldr" ? "ldr" : "hdr", signal),
        });
    return wanted;
  });

  entry(index: number): Entry | null {
    const name = this.part("images").value[index];
    return (name && this.store.entries.value.get(this.key(name))) || null;
  }

  flipEntry(index: number): Entry | null {
    const images = this.part("images").value;
    const name = images[index];
    const reference = images[this.reference.value];
    return (name && reference && this.store.entries.value.get(this.flipKey(name, reference))) || null;
  }

  pixels = (index: number): PixelImage | null => this.entry(index)?.image ?? null;

  private readonly held = computed(
    () => new Set([...this.store.entries.value.values()].flatMap((entry) => (entry.image ? [entry.image] : []))),
  );

  // --- What is shown

  readonly ground = computed((): Ground => {
    const images = this.part("images").value.map((_, index) => this.pixels(index)).filter((image) => image !== null);
    const numbers = (values: (number | null)[]) => values.filter((value) => value !== null);
    const lows = numbers(images.map((image) => image.statistics.low));
    const highs = numbers(images.map((image) => image.statistics.high));
    return {
      layer: this.part("layer").value,
      channels: images[0]?.channels ?? 3,
      referenceMean: this.pixels(this.reference.value)?.statistics.mean ?? null,
      low: lows.length ? Math.min(...lows) : null,
      high: highs.length ? Math.max(...highs) : null,
    };
  });

  /** Why an image has no error map of the kind chosen; null where it has one. */
  whyNoError(index: number): string | null {
    const image = this.pixels(index);
    const reference = this.pixels(this.reference.value);
    const layer = this.part("layer").value;
    if (!image) return "it is not there yet";
    if (!reference) return "the reference is not there yet";
    if (!sameSize(image, reference)) return `no error map: the reference has ${reference.width} × ${reference.height} pixels, this image ${image.width} × ${image.height}`;
    if (image.channels !== reference.channels) return `no error map: the reference has ${reference.channels} channels, this image ${image.channels}`;
    if (this.part("error").value.startsWith("flip") && !isMeasured(layer)) return `no FLIP: ${layer} is no layer of light`;
    return null;
  }

  /** By which values an image becomes colours; those of the reference itself are no errors. */
  readonly paints = computed((): { image: Paint; error: Paint } => {
    const look = this.displayed.value;
    return { image: paintOf(look, this.ground.value, "none"), error: paintOf(look, this.ground.value, look.error) };
  });
  /** The look without where it is looked at, so that panning computes nothing anew. */
  private readonly displayed = computed((): Look => ({
    ...kStart,
    layer: this.part("layer").value,
    exposure: this.part("exposure").value,
    curve: this.part("curve").value,
    colours: this.part("colours").value,
    channel: this.part("channel").value,
    error: this.part("error").value,
    span: this.part("span").value,
    range: this.part("range").value,
  }));

  readonly shown = computed((): Shown[] => this.part("images").value.map((name, index) => this.shownOf(name, index)));

  private shownOf(name: string, index: number): Shown {
    const source = this.sources.value.get(name);
    const layer = this.part("layer").value;
    if (source?.failure) return { picture: null, busy: false, note: source.failure.message };
    if (!source?.size) return { picture: null, busy: true, note: null };
    if (!source.layers.includes(layer)) return { picture: null, busy: false, note: `${source.title} has no layer ${layer}` };
    const entry = this.entry(index);
    const image = entry?.image ?? null;
    if (!image) {
      if (entry?.failure) return { picture: null, busy: false, note: entry.failure.message };
      return entry?.waiting ? { picture: null, busy: false, note: "Nothing is rendered yet" } : { picture: null, busy: true, note: null };
    }
    const tooLarge = this.developer.value?.whyNot(image) ?? null;
    if (tooLarge) return { picture: null, busy: false, note: tooLarge };
    const error = this.part("error").value;
    const reference = this.reference.value;
    const stale = entry?.failure ? `This is not the newest: ${entry.failure.message}` : null;
    if (error === "none" || index === reference) return { picture: { image, reference: null, paint: this.paints.value.image }, busy: false, note: stale };
    const why = this.whyNoError(index);
    if (why) return { picture: null, busy: false, note: why };
    if (!error.startsWith("flip")) return { picture: { image, reference: this.pixels(reference), paint: this.paints.value.error }, busy: false, note: stale };
    const flip = this.flipEntry(index);
    if (flip?.image) return { picture: { image: flip.image, reference: null, paint: this.paints.value.error }, busy: false, note: stale };
    if (flip?.failure) return { picture: null, busy: false, note: flip.failure.message };
    return flip?.waiting ? { picture: null, busy: false, note: "Nothing is rendered yet" } : { picture: null, busy: true, note: "FLIP is computed" };
  }

  /** The size that the view goes by: of the shown image, or of any while that is not known. */
  readonly size = computed((): Size => {
    const images = this.part("images").value;
    const sizes = [images[this.part("shown").value], ...images].map((name) => (name ? (this.sources.value.get(name)?.size ?? null) : null));
    return sizes.find((size) => size !== null) ?? { width: 16, height: 9 };
  });
  readonly sizesDiffer = computed(() => {
    const sizes = this.part("images").value.flatMap((name) => this.sources.value.get(name)?.size ?? []);
    return sizes.some((size) => !sameSize(size, sizes[0]!));
  });

  readonly panes = computed((): Pane[] => {
    const stage = this.stage.value;
    const images = this.part("images").value;
    const mode = this.part("mode").value;
    const shown = Math.min(this.part("shown").value, images.length - 1);
    const whole: Box = { x: 0, y: 0, ...stage };
    if (images.length === 0) return [];
    if (mode === "grid") return gridOf(images.length, this.size.value, stage).map((box, index) => ({ index, box, clip: box }));
    if (mode === "single" || images.length === 1) return [{ index: shown, box: whole, clip: whole }];
    const beside = this.beside.value;
    if (mode === "side") {
      const [left, right] = gridOf(2, this.size.value, stage) as [Box, Box];
      return [{ index: shown, box: left, clip: left }, { index: beside, box: right, clip: right }];
    }
    const wipe = this.part("wipe").value;
    const across = this.part("wipeAcross").value;
    const x = Math.round(wipe * stage.width);
    const y = Math.round(wipe * stage.height);
    return [
      { index: shown, box: whole, clip: across ? { ...whole, height: y } : { ...whole, width: x } },
      { index: beside, box: whole, clip: across ? { ...whole, y, height: stage.height - y } : { ...whole, x, width: stage.width - x } },
    ];
  });

  /** Of a pane: all panes are of one size. */
  readonly paneSize = computed((): Size => this.panes.value[0]?.box ?? this.stage.value);

  readonly view = computed((): View => {
    const fit = fitted(this.size.value, this.paneSize.value);
    return { zoom: this.part("zoom").value ?? fit.zoom, centre: this.part("centre").value ?? fit.centre };
  });

  setView(view: View): void {
    this.change({ zoom: view.zoom, centre: view.centre });
  }

  fit(): void {
    this.change({ zoom: null, centre: null });
  }

  /** The pixel that the table of values is of. */
  readonly pixel = computed(() => this.hovered.value ?? this.part("pixel").value);
}

export const sameSize = (a: Size | null, b: Size | null): boolean => !!a && !!b && a.width === b.width && a.height === b.height;
