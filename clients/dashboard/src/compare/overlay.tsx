// What lies over the pictures: their names, why one is missing, the wipe's handle, crops and the pixel that is read.

import { useRef } from "preact/hooks";

import { cropBetween, type Crop } from "./crops";
import type { Desk, Pane } from "./desk";
import { PixelNumbers } from "./pixel_numbers";
import { clamp, panePoint, type Box, type Point } from "./view";

export function Overlay({ desk, drawn }: { desk: Desk; drawn: { from: Point; to: Point } | null }) {
  const wipes = desk.part("mode").value === "wipe" && desk.panes.value.length === 2;
  return (
    <>
      <PixelNumbers desk={desk} />
      <Marks desk={desk} drawn={drawn} />
      {desk.panes.value.map((pane, i) => (
        <Label key={`${pane.index}-${i}`} desk={desk} pane={pane} atEnd={wipes && i === 1} />
      ))}
      {wipes && <Wipe desk={desk} />}
    </>
  );
}

function styleOf(box: Box, density: number): Record<string, string> {
  return { left: `${box.x / density}px`, top: `${box.y / density}px`, width: `${box.width / density}px`, height: `${box.height / density}px` };
}

function Label({ desk, pane, atEnd }: { desk: Desk; pane: Pane; atEnd: boolean }) {
  const name = desk.part("images").value[pane.index];
  const source = name === undefined ? undefined : desk.sources.value.get(name);
  const shown = desk.shown.value[pane.index];
  const across = desk.part("wipeAcross").value;
  const isReference = pane.index === desk.reference.value;
  return (
    <div class={`compare-pane${atEnd ? (across ? " at-bottom" : " at-right") : ""}`} style={styleOf(pane.clip, desk.density.value)}>
      <span class="compare-name" title={source?.title ?? name}>
        <b>{pane.index + 1}</b> {source?.title ?? name}
        {isReference && desk.part("images").value.length > 1 && " · reference"}
      </span>
      {(shown?.busy || shown?.note) && (
        <span class={shown.picture ? "compare-note small" : "compare-note"} role="status">
          {shown.busy && <span class="compare-busy" aria-hidden="true" />}
          {shown.note ?? "Pixels are fetched"}
          {shown.busy && " …"}
        </span>
      )}
    </div>
  );
}

const kWipeStep = 0.02;

function Wipe({ desk }: { desk: Desk }) {
  const held = useRef(false);
  const across = desk.part("wipeAcross").value;
  const wipe = desk.part("wipe").value;
  const place = `${100 * wipe}%`;
  const to = (share: number) => desk.change({ wipe: clamp(share, 0, 1) });
  function follow(event: PointerEvent): void {
    if (!held.current) return;
    const stage = (event.currentTarget as Element).parentElement!.getBoundingClientRect();
    to(across ? (event.clientY - stage.top) / stage.height : (event.clientX - stage.left) / stage.width);
  }
  function onKeyDown(event: KeyboardEvent): void {
    const step = event.shiftKey ? 5 * kWipeStep : kWipeStep;
    const places: Record<string, number> = { ArrowLeft: wipe - step, ArrowUp: wipe - step, ArrowRight: wipe + step, ArrowDown: wipe + step, Home: 0, End: 1 };
    const next = places[event.key];
    if (next === undefined) return;
    to(next);
    event.preventDefault();
  }
  return (
    <div
      class={`compare-wipe${across ? " across" : ""}`}
      style={across ? { top: place } : { left: place }}
      role="slider"
      tabIndex={0}
      aria-label="Wipe"
      aria-orientation={across ? "vertical" : "horizontal"}
      aria-valuemin={0}
      aria-valuemax={100}
      aria-valuenow={Math.round(100 * wipe)}
      aria-valuetext={`${Math.round(100 * wipe)} % of the pane is the first image`}
      onPointerDown={(event) => {
        held.current = true;
        (event.currentTarget as Element).setPointerCapture(event.pointerId);
      }}
      onPointerMove={follow}
      onPointerUp={() => (held.current = false)}
      onPointerCancel={() => (held.current = false)}
      onDblClick={(event) => {
        event.stopPropagation();
        to(0.5);
      }}
      onKeyDown={onKeyDown}
    >
      <span aria-hidden="true" />
    </div>
  );
}

/** Crops and the pixel, in every pane. */
function Marks({ desk, drawn }: { desk: Desk; drawn: { from: Point; to: Point } | null }) {
  const view = desk.view.value;
  const density = desk.density.value;
  const crops: (Crop & { isNew?: boolean })[] = [...desk.part("crops").value];
  const drawing = drawn && cropBetween(drawn.from, drawn.to, desk.size.value);
  if (drawing) crops.push({ ...drawing, isNew: true });
  const pixel = desk.part("pixel").value;
  const panes = desk.part("mode").value === "wipe" ? desk.panes.value.slice(0, 1) : desk.panes.value;
  if (crops.length === 0 && !pixel) return null;
  return (
    <>
      {panes.map(({ box, index }) => (
        <svg key={index} class="compare-marks" style={styleOf(box, density)} viewBox={`0 0 ${box.width} ${box.height}`} aria-hidden="true">
          {crops.map((crop, i) => {
            const corner = panePoint(view, box, crop);
            const side = { width: crop.width * view.zoom, height: crop.height * view.zoom };
            return (
              <g key={i}>
                <rect class="under" x={corner.x} y={corner.y} {...side} />
                <rect class={crop.isNew ? "crop new" : "crop"} x={corner.x} y={corner.y} {...side} />
                {!crop.isNew && (
                  <text x={corner.x + 4 * density} y={corner.y - 5 * density} font-size={12 * density}>
                    {"ABCDEF"[i]}
                  </text>
                )}
              </g>
            );
          })}
          {pixel && <Crosshair at={panePoint(view, box, pixel)} side={view.zoom} density={density} />}
        </svg>
      ))}
    </>
  );
}

function Crosshair({ at, side, density }: { at: Point; side: number; density: number }) {
  const [x, y] = [at.x + side / 2, at.y + side / 2];
  const [inner, outer] = [Math.max(side / 2 + 2 * density, 5 * density), Math.max(side / 2 + 2 * density, 5 * density) + 10 * density];
  const lines = `M${x - outer} ${y}H${x - inner}M${x + inner} ${y}H${x + outer}M${x} ${y - outer}V${y - inner}M${x} ${y + inner}V${y + outer}`;
  const around = side >= 4 ? `M${at.x} ${at.y}h${side}v${side}h${-side}z` : "";
  return (
    <g>
      <path class="under" d={lines + around} />
      <path class="crop" d={lines + around} />
    </g>
  );
}
