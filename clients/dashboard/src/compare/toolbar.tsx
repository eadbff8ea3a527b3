// How the images are laid out, which of their values are shown and how.

import type { ComponentChildren } from "preact";
import { useEffect, useState } from "preact/hooks";

import { isMeasured } from "../api/vocabulary";
import { numberText, percentText } from "../ui/format";
import { autoExposureStops } from "./auto_exposure";
import type { Desk } from "./desk";
import { kChannels, kCurves, kErrors, kFalseColours, kModes, type Channel, type Curve, type ErrorKind, type FalseColours, type Look, type Mode } from "./look";
import { channelNames, isLight, layerKind, rangeOf, spanOf } from "./paint";
import { clamp, nextZoom, zoomedAt } from "./view";

export const kModeNames: Record<Mode, string> = { single: "One", wipe: "Wipe", side: "Side by side", grid: "All" };
const kErrorNames: Record<ErrorKind, string> = { none: "None", signed: "Signed", relative: "Relative", flip_hdr: "FLIP (HDR)", flip_ldr: "FLIP (LDR)" };
const kCurveNames: Record<Curve, string> = { srgb: "sRGB, clipped", filmic: "Filmic", aces: "ACES fitted", agx: "AgX", neutral: "PBR Neutral", linear: "Linear" };
const kColourNames: Record<FalseColours, string> = { usual: "Usual", viridis: "Viridis", magma: "Magma", inferno: "Inferno", plasma: "Plasma", turbo: "Turbo", grey: "Grey" };
export const kExposureStep = 0.5;
const kExposureReach = 10;

/** About the middle of the pane. */
export function zoomBy(desk: Desk, larger: boolean): void {
  const pane = desk.paneSize.peek();
  const view = desk.view.peek();
  desk.setView(zoomedAt(view, pane, { x: pane.width / 2, y: pane.height / 2 }, nextZoom(view.zoom, larger)));
}

export function zoomTo(desk: Desk, zoom: number): void {
  desk.setView({ ...desk.view.peek(), zoom });
}

function Choice<Value extends string>({ desk, name, label, options, disabled }: { desk: Desk; name: keyof Look; label: string; options: [Value, string][]; disabled?: boolean }) {
  return (
    <label class="compare-field">
      <span>{label}</span>
      <select
        value={String(desk.part(name).value)}
        disabled={disabled}
        onChange={(event) => desk.change({ [name]: event.currentTarget.value } as Partial<Look>)}
      >
        {options.map(([value, text]) => (
          <option key={value} value={value}>
            {text}
          </option>
        ))}
      </select>
    </label>
  );
}

/** A number that is taken over when it is one. */
export function NumberBox({ label, value, onValue, step = "any", min, max }: { label: string; value: number; onValue: (value: number) => void; step?: number | "any"; min?: number; max?: number }) {
  const shown = String(Number(value.toPrecision(6)));
  const [text, setText] = useState(shown);
  useEffect(() => setText(shown), [shown]);
  const faulty = text.trim() === "" || !Number.isFinite(Number(text)) || (min !== undefined && Number(text) < min) || (max !== undefined && Number(text) > max);
  return (
    <input
      type="number"
      aria-label={label}
      aria-invalid={faulty}
      value={text}
      step={step}
      min={min}
      max={max}
      onInput={(event) => {
        const typed = event.currentTarget.value;
        setText(typed);
        const number = Number(typed);
        if (typed.trim() !== "" && Number.isFinite(number) && (min === undefined || number >= min) && (max === undefined || number <= max)) onValue(number);
      }}
      onBlur={() => setText(shown)}
    />
  );
}

function Modes({ desk }: { desk: Desk }) {
  const several = desk.part("images").value.length > 1;
  const mode = desk.part("mode").value;
  return (
    <div class="compare-segments" role="group" aria-label="Layout">
      {kModes.map((one) => (
        <button key={one} aria-pressed={(several ? mode : "single") === one} disabled={!several && one !== "single"} onClick={() => desk.change({ mode: one })}>
          {kModeNames[one]}
        </button>
      ))}
      {several && mode === "wipe" && (
        <button
          aria-label={desk.part("wipeAcross").value ? "Wipe from left to right instead" : "Wipe from top to bottom instead"}
          title="Turn the wipe (h)"
          onClick={() => desk.change({ wipeAcross: !desk.look.peek().wipeAcross })}
        >
          {desk.part("wipeAcross").value ? "⬍" : "⬌"}
        </button>
      )}
    </div>
  );
}

function Layers({ desk }: { desk: Desk }) {
  const count = desk.part("images").value.length;
  const choices = desk.layers.value;
  const layer = desk.part("layer").value;
  const options = choices.map(({ name, of }): [string, string] => [name, of.length === count ? name : `${name} (${of.length} of ${count})`]);
  if (!choices.some((choice) => choice.name === layer)) options.unshift([layer, `${layer} (none has it)`]);
  return <Choice desk={desk} name="layer" label="Layer" options={options} />;
}

function Exposure({ desk }: { desk: Desk }) {
  const exposure = desk.part("exposure").value;
  const to = (value: number) => desk.change({ exposure: clamp(value, -30, 30) });
  const image = desk.pixels(desk.part("shown").value);
  const auto = image && autoExposureStops(image);
  return (
    <div class="compare-field compare-exposure">
      <label>
        <span>Exposure</span>
        <input type="range" min={-kExposureReach} max={kExposureReach} step={0.1} value={exposure} aria-valuetext={`${numberText(exposure)} stops`} onInput={(event) => to(Number(event.currentTarget.value))} />
      </label>
      <span class="with-unit">
        <NumberBox label="Exposure in stops" value={exposure} step={0.5} min={-30} max={30} onValue={to} />
        <span>stops</span>
      </span>
      <button aria-label="Auto exposure" disabled={auto === null} onClick={() => auto !== null && to(auto)} title="So that the log-average luminance of the image shown is middle grey (A)">
        Auto
      </button>
      <button class="quiet" disabled={exposure === 0} onClick={() => to(0)} aria-label="Exposure back to 0" title="Back to 0">
        ↺
      </button>
    </div>
  );
}

/** The ends of a scale that exposure does not move. */
function Scale({ desk, error }: { desk: Desk; error: boolean }) {
  const look = desk.look.value;
  const ground = desk.ground.value;
  if (error) {
    const span = spanOf(look, ground);
    return (
      <div class="compare-field">
        <span>Scale ±</span>
        <NumberBox label="Signed error at the ends of the scale" value={span} min={1e-12} onValue={(value) => desk.change({ span: value })} />
        <button class="quiet" disabled={look.span === null} onClick={() => desk.change({ span: null })}>
          Usual
        </button>
      </div>
    );
  }
  const [low, high] = rangeOf(look, ground);
  return (
    <div class="compare-field">
      <span>Scale from</span>
      <NumberBox label="Least value of the scale" value={low} max={high} onValue={(value) => value < high && desk.change({ range: [value, high] })} />
      <span>to</span>
      <NumberBox label="Greatest value of the scale" value={high} min={low} onValue={(value) => value > low && desk.change({ range: [low, value] })} />
      <button class="quiet" disabled={look.range === null} onClick={() => desk.change({ range: null })}>
        Usual
      </button>
    </div>
  );
}

function Zoom({ desk }: { desk: Desk }) {
  const zoom = desk.view.value.zoom;
  return (
    <div class="compare-segments" role="group" aria-label="Zoom">
      <button onClick={() => zoomBy(desk, false)} aria-label="Smaller" title="Smaller (−)">
        −
      </button>
      <output class="compare-zoom" aria-label="Zoom" title="Screen pixels to an image pixel">
        {percentText(zoom)}
      </output>
      <button onClick={() => zoomBy(desk, true)} aria-label="Larger" title="Larger (+)">
        +
      </button>
      <button aria-pressed={zoom === 1} onClick={() => zoomTo(desk, 1)} title="A pixel of the image to a pixel of the screen (z)">
        1:1
      </button>
      <button aria-pressed={desk.part("zoom").value === null} onClick={() => desk.fit()} title="All of the image (f)">
        Fit
      </button>
    </div>
  );
}

function Group({ children }: { children: ComponentChildren }) {
  return <div class="row">{children}</div>;
}

export function Toolbar({ desk }: { desk: Desk }) {
  const ground = desk.ground.value;
  const several = desk.part("images").value.length > 1;
  const error = several ? desk.part("error").value : "none";
  const [x = "", y = "", z = ""] = channelNames(layerKind(ground.layer, 3), 3);
  const channelText: Record<Channel, string> = { rgb: x + y + z, r: x, g: y, b: z, luminance: "Luminance" };
  const light = isLight(ground.layer, ground.channels);
  const channels = kChannels.filter((channel) => channel !== "luminance" || light);
  // A kind that the layer has not is still listed while it is chosen: the panes say why they have none.
  const errors = kErrors.filter((kind) => !kind.startsWith("flip") || isMeasured(ground.layer) || kind === error);
  return (
    <div class="compare-tools" role="group" aria-label="Display">
      <Group>
        <Modes desk={desk} />
        <Zoom desk={desk} />
        {several && <Choice desk={desk} name="error" label="Error" options={errors.map((kind) => [kind, kErrorNames[kind]])} />}
        {error === "signed" && <Scale desk={desk} error />}
      </Group>
      <Group>
        <Layers desk={desk} />
        {ground.channels === 3 && !error.startsWith("flip") && <Choice desk={desk} name="channel" label="Channel" options={channels.map((channel) => [channel, channelText[channel]])} />}
        {light && (
          <>
            <Exposure desk={desk} />
            <Choice desk={desk} name="curve" label="View transform" options={kCurves.map((curve) => [curve, kCurveNames[curve]])} />
          </>
        )}
        {!light && error === "none" && <Scale desk={desk} error={false} />}
        {error !== "signed" && <Choice desk={desk} name="colours" label="Colours" options={kFalseColours.map((colours) => [colours, kColourNames[colours]])} />}
        <Choice desk={desk} name="precision" label="Precision" options={[["half", "Half"], ["float", "Full"]]} />
      </Group>
    </div>
  );
}
