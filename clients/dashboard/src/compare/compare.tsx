// Compare images: two to nine, seen in one view that the address holds.

import "./compare.css";

import { effect } from "@preact/signals";
import { useEffect, useMemo, useRef, useState } from "preact/hooks";

import { useKeys } from "../app/keyboard";
import { Title } from "../app/title";
import { useQuery } from "../app/url_state";
import { say, sayFailure } from "../ui/toasts";
import { ColourBar } from "./colour_bar";
import { CropStrip } from "./crop_strip";
import { Desk } from "./desk";
import { ErrorsTable } from "./errors_table";
import { saveCrops, saveView } from "./export";
import { HistogramPanel } from "./histogram_panel";
import { ImageList } from "./image_list";
import { compareKeys } from "./keys";
import { kMaxImages, lookOf, queryOf, withImages } from "./look";
import { Picker } from "./picker";
import { Readout } from "./readout";
import { Stage } from "./stage";
import { Start } from "./start";
import { Toolbar } from "./toolbar";
import { uploadImage } from "./uploads";

/** Browsers take few changes of an address a second; it follows when the view has come to rest. */
const kAddressMs = 250;

const textOf = (members: Record<string, string | null | undefined>): string => JSON.stringify(Object.entries(members).filter(([, value]) => value));

/** Keeps the address and what is shown the same; returns the faults of the address. */
function useAddress(desk: Desk): string[] {
  const [query, change] = useQuery();
  const changeNow = useRef(change);
  changeNow.current = change;
  const written = useRef<string | null>(null);
  const [faults, setFaults] = useState<string[]>([]);
  // Before the first picture, so that the start page does not show for a moment.
  useMemo(() => (desk.look.value = lookOf(query).look), []);
  useEffect(() => {
    const read = lookOf(query);
    const text = textOf(queryOf(read.look));
    if (text === written.current) return;
    written.current = text;
    setFaults(read.faults);
    desk.look.value = read.look;
  }, [query]);
  useEffect(() => {
    let timer: ReturnType<typeof setTimeout> | undefined;
    const stop = effect(() => {
      const members = queryOf(desk.look.value);
      clearTimeout(timer);
      timer = setTimeout(() => {
        const text = textOf(members);
        if (text === written.current) return;
        written.current = text;
        setFaults([]);
        changeNow.current(members);
      }, kAddressMs);
    });
    return () => {
      stop();
      clearTimeout(timer);
    };
  }, [desk]);
  return faults;
}

export function Compare() {
  const desk = useMemo(() => new Desk(), []);
  const faults = useAddress(desk);
  const canvas = useRef<HTMLCanvasElement | null>(null);
  const [picking, setPicking] = useState(false);
  const [dragging, setDragging] = useState(false);
  useEffect(() => desk.start(), [desk]);
  const keys = useMemo(() => compareKeys(desk), [desk]);
  useKeys("Compare images", keys, [keys]);
  const images = desk.part("images").value;

  const add = (sources: string[]) => {
    const look = withImages(desk.look.peek(), sources);
    if (sources.some((source) => !look.images.includes(source))) say(`${kMaxImages} images at most: not all were added`);
    desk.look.value = look;
  };
  async function addFiles(files: File[]): Promise<void> {
    for (const file of files) {
      try {
        add([await uploadImage(file)]);
        say(`${file.name} is there`);
      } catch (failure) {
        sayFailure(failure);
      }
    }
  }
  async function copyLink(): Promise<void> {
    const members = Object.entries(queryOf(desk.look.peek())).filter((member): member is [string, string] => member[1] !== null);
    try {
      await navigator.clipboard.writeText(`${location.origin}${location.pathname}?${new URLSearchParams(members)}`);
      say("A link to this view is copied");
    } catch {
      sayFailure(new Error("The browser does not let the page copy. The address of this page is the link."));
    }
  }
  const hasFiles = (event: DragEvent) => event.dataTransfer?.types.includes("Files") ?? false;

  return (
    <div
      class={`compare${dragging ? " dragging" : ""}`}
      onDragOver={(event) => {
        if (!hasFiles(event)) return;
        event.preventDefault();
        setDragging(true);
      }}
      onDragLeave={(event) => {
        if (!event.currentTarget.contains(event.relatedTarget as Node | null)) setDragging(false);
      }}
      onDrop={(event) => {
        if (!hasFiles(event)) return;
        event.preventDefault();
        setDragging(false);
        void addFiles([...event.dataTransfer!.files]);
      }}
    >
      <Title text="Compare images">
        {images.length > 0 && (
          <>
            <button onClick={() => void copyLink()}>Copy link</button>
            <button onClick={() => saveView(desk, canvas.current!).catch(sayFailure)}>Save view as PNG</button>
            <button class="primary" onClick={() => setPicking(true)} disabled={images.length >= kMaxImages}>
              Add images …
            </button>
          </>
        )}
      </Title>
      {faults.length > 0 && (
        <div class="notice" role="alert">
          The address says what this page does not understand:
          <ul>
            {faults.map((fault) => (
              <li key={fault}>{fault}</li>
            ))}
          </ul>
        </div>
      )}
      {images.length === 0 ? (
        <Start onPick={() => setPicking(true)} onFiles={(files) => void addFiles(files)} />
      ) : (
        <>
          <div class="compare-room">
            <div class="compare-main">
              <Toolbar desk={desk} />
              <Stage desk={desk} canvasRef={canvas} />
              <ColourBar desk={desk} />
            </div>
            <div class="compare-side">
              <ImageList desk={desk} onAdd={() => setPicking(true)} />
              <Readout desk={desk} />
              <HistogramPanel desk={desk} />
            </div>
          </div>
          <CropStrip desk={desk} onSave={() => saveCrops(desk).catch(sayFailure)} />
          <ErrorsTable desk={desk} />
        </>
      )}
      {picking && <Picker images={images} size={images.length ? desk.size.value : null} onAdd={add} onFiles={(files) => void addFiles(files)} onClose={() => setPicking(false)} />}
      {dragging && (
        <div class="compare-dropping" aria-hidden="true">
          Drop OpenEXR or Radiance files to compare them
        </div>
      )}
    </div>
  );
}
