// The panels of the form for a new comparison.

import { useState } from "preact/hooks";

import type { Device, Fault, Method, Scene } from "../api/types";
import { countText, plainName } from "../ui/format";
import { MethodForm } from "../ui/method_form";
import { fieldsOf, rangeText } from "../ui/parameter_form";
import { Picture } from "../ui/picture";
import { usualMetrics } from "./metric_texts";
import { entryOf, faultsUnder, kPresets, pointerToken, valuesOf, type EntryPlan, type Plan, type SweepPlan, withPreset } from "./plan";

type Set = (members: Partial<Plan>) => void;

/** The faults at a field, said beneath it. */
export function Faults({ faults, at }: { faults: Fault[]; at: string }) {
  const found = faultsUnder(faults, at);
  return (
    <>
      {found.map((fault) => (
        <span key={fault.pointer + fault.detail} class="fault" role="alert">
          {fault.detail}
        </span>
      ))}
    </>
  );
}

export function FaultList({ faults }: { faults: Fault[] }) {
  if (faults.length === 0) return null;
  return (
    <ul>
      {faults.map((fault) => (
        <li key={fault.pointer + fault.detail}>
          <code>{fault.pointer}</code>: {fault.detail}
        </li>
      ))}
    </ul>
  );
}

const isWrong = (faults: Fault[], at: string) => (faultsUnder(faults, at).length > 0 ? ("true" as const) : undefined);

// -- scene and size -----------------------------------------------------------------------------------------------------

const kSizes: [number, number][] = [[128, 128], [256, 256], [512, 512], [640, 360], [1280, 720]];

function SceneCard({ scene, chosen, onChoose }: { scene: Scene; chosen: boolean; onChoose: () => void }) {
  return (
    <label class={chosen ? "new-study-scene chosen" : "new-study-scene"}>
      <input class="visually-hidden" type="radio" name="scene" value={scene.id} checked={chosen} onChange={onChoose} />
      <Picture path={`/v1/scenes/${encodeURIComponent(scene.id)}/thumbnail.png`} alt="" waiting="…" />
      <span class="new-study-scene-name">{scene.name}</span>
      <small class="muted">{countText(scene.triangles)} triangles</small>
    </label>
  );
}

interface SceneProps {
  plan: Plan;
  set: Set;
  scenes: Scene[];
  faults: Fault[];
}

/** A number field that says nothing while it is empty. */
function NumberField(props: { label: string; value: number | null | undefined; wrong: "true" | undefined; min?: number; step?: string; unit?: string; onValue: (value: number | null) => void }) {
  return (
    <label class="field">
      {props.label}
      <span class="with-unit">
        <input
          type="number"
          min={props.min ?? 0}
          step={props.step ?? "any"}
          value={props.value ?? ""}
          aria-invalid={props.wrong}
          onInput={(event) => props.onValue(Number.isNaN(event.currentTarget.valueAsNumber) ? null : event.currentTarget.valueAsNumber)}
        />
        {props.unit && <span>{props.unit}</span>}
      </span>
    </label>
  );
}

export function ScenePanel({ plan, set, scenes, faults }: SceneProps) {
  const known = scenes.some((scene) => scene.id === plan.scene || scene.name === plan.scene);
  const isChosen = (scene: Scene) => scene.id === plan.scene || (scene.builtin && scene.name === plan.scene);
  return (
    <section class="panel stack" aria-labelledby="new-study-scene">
      <div class="row">
        <h2 id="new-study-scene" class="new-study-fill">
          Scene
        </h2>
        <a href="/scenes">Upload a scene</a>
      </div>
      <div class="new-study-scenes" role="radiogroup" aria-label="Scene">
        {!known && (
          <label class="new-study-scene chosen">
            <input class="visually-hidden" type="radio" name="scene" value={plan.scene} checked />
            <Picture path={`/v1/scenes/${encodeURIComponent(plan.scene)}/thumbnail.png`} alt="" waiting="…" />
            <span class="new-study-scene-name">{plan.scene}</span>
          </label>
        )}
        {scenes.map((scene) => (
          <SceneCard key={scene.id} scene={scene} chosen={isChosen(scene)} onChoose={() => set({ scene: scene.id, more: { ...plan.more, camera: undefined } })} />
        ))}
      </div>
      {plan.more.camera != null && (
        <p class="small new-study-view">
          Seen from a view of its own.{" "}
          <button class="quiet" onClick={() => set({ more: { ...plan.more, camera: undefined } })}>
            Use the scene's camera
          </button>
        </p>
      )}
      <Faults faults={faults} at="/scene" />
      <div class="row new-study-size">
        <div class="row" role="group" aria-label="Usual sizes">
          {kSizes.map(([width, height]) => (
            <button key={`${width}x${height}`} aria-pressed={plan.width === width && plan.height === height} onClick={() => set({ width, height })}>
              {width} × {height}
            </button>
          ))}
        </div>
        <NumberField label="Width" value={plan.width} min={1} step="1" wrong={isWrong(faults, "/image/width")} onValue={(width) => set({ width: width ?? 0 })} />
        <NumberField label="Height" value={plan.height} min={1} step="1" wrong={isWrong(faults, "/image/height")} onValue={(height) => set({ height: height ?? 0 })} />
      </div>
      <Faults faults={faults} at="/image" />
      <Faults faults={faults} at="/camera" />
    </section>
  );
}

// -- entries ------------------------------------------------------------------------------------------------------------

interface SweepProps {
  sweep: SweepPlan;
  method: Method | undefined;
  faults: Fault[];
  id: string;
  onChange: (sweep: SweepPlan) => void;
  onRemove: () => void;
}

function SweepEditor({ sweep, method, faults, id, onChange, onRemove }: SweepProps) {
  const fields = method ? fieldsOf(method) : [];
  const field = fields.find((other) => other.name === sweep.parameter);
  const values = valuesOf(sweep.values);
  const hint = field ? (field.schema.enum ? field.schema.enum.join(", ") : rangeText(field)) : "";
  const at = `/sweep/${pointerToken(sweep.parameter)}`;
  return (
    <div class="new-study-sweep">
      <label class="field">
        Parameter
        <select value={sweep.parameter} onChange={(event) => onChange({ ...sweep, parameter: event.currentTarget.value })}>
          {!field && <option value={sweep.parameter}>{sweep.parameter || "choose"}</option>}
          {fields.map((other) => (
            <option key={other.name} value={other.name}>
              {plainName(other.name)}
            </option>
          ))}
        </select>
      </label>
      <div class="field">
        <label for={`${id}-values`}>Values</label>
        <input
          id={`${id}-values`}
          value={sweep.values}
          placeholder="1000, 10000, 100000"
          autocomplete="off"
          aria-invalid={isWrong(faults, at)}
          aria-describedby={`${id}-hint`}
          onInput={(event) => onChange({ ...sweep, values: event.currentTarget.value })}
        />
        <span id={`${id}-hint`} class="hint">
          <Faults faults={faults} at={at} /> {values.length} {values.length === 1 ? "value" : "values"}
          {hint && ` · ${hint}`}
        </span>
      </div>
      <button class="quiet" aria-label={`Remove the sweep of ${sweep.parameter || "a parameter"}`} onClick={onRemove}>
        ✕
      </button>
    </div>
  );
}

interface EntryProps {
  entry: EntryPlan;
  index: number;
  label: string;
  alone: boolean;
  methods: Method[];
  devices: Device[];
  faults: Fault[];
  onChange: (entry: EntryPlan) => void;
  onCopy: () => void;
  onRemove: () => void;
}

/** "Photon mapping on cpu; gather direct; photons swept over 3 values" */
function summaryOf(entry: EntryPlan, method: Method | undefined): string {
  const set = Object.entries(entry.method.parameters ?? {}).map(([name, value]) => `${plainName(name)} ${String(value)}`);
  const swept = entry.sweeps.map((sweep) => `${plainName(sweep.parameter)}: ${valuesOf(sweep.values).join(", ")}`);
  return [`${method?.title ?? entry.method.name} on ${entry.method.device ?? "cpu"}`, ...(set.length + swept.length ? [...set, ...swept] : ["everything as by default"])].join("; ");
}

function EntryCard({ entry, index, label, alone, methods, devices, faults, onChange, onCopy, onRemove }: EntryProps) {
  const method = methods.find((other) => other.name === entry.method.name);
  const id = `entry-${entry.key}`;
  const [open, setOpen] = useState(false);
  const setSweep = (i: number, sweep: SweepPlan | null) =>
    onChange({ ...entry, sweeps: sweep ? entry.sweeps.map((old, j) => (j === i ? sweep : old)) : entry.sweeps.filter((_, j) => j !== i) });
  const addSweep = () => {
    const free = (method ? fieldsOf(method) : []).filter((field) => !entry.sweeps.some((sweep) => sweep.parameter === field.name));
    const first = free.find((field) => field.name === "photons") ?? free[0];
    onChange({ ...entry, sweeps: [...entry.sweeps, { parameter: first?.name ?? "", values: "" }] });
  };
  return (
    <li class="new-study-entry">
      <div class="row">
        <h3 class="new-study-fill">
          {index + 1}. {label}
        </h3>
        <button class="quiet" onClick={onCopy}>
          Copy<span class="visually-hidden"> {label}</span>
        </button>
        <button class="quiet" disabled={alone} onClick={onRemove}>
          Remove<span class="visually-hidden"> {label}</span>
        </button>
      </div>
      <p class="muted">{summaryOf(entry, method)}</p>
      <details class="new-study-settings" open={open || faults.length > 0} onToggle={(event) => setOpen(event.currentTarget.open)}>
        <summary>
          Method and settings<span class="visually-hidden"> of {label}</span>
        </summary>
        <div class="stack">
          <MethodForm
            methods={methods}
            devices={devices}
            value={entry.method}
            onChange={(choice) => onChange({ ...entry, method: choice, ...(choice.name === entry.method.name ? {} : { sweeps: [] }) })}
            faults={faultsUnder(faults, "/method")}
            idPrefix={id}
          />
          {entry.sweeps.map((sweep, i) => (
            <SweepEditor key={i} id={`${id}-sweep-${i}`} sweep={sweep} method={method} faults={faults} onChange={(next) => setSweep(i, next)} onRemove={() => setSweep(i, null)} />
          ))}
          {faults
            .filter((fault) => fault.pointer === "" || fault.pointer === "/sweep" || fault.pointer === "/label")
            .map((fault) => (
              <p key={fault.detail} class="fault" role="alert">
                {fault.detail}
              </p>
            ))}
          <div class="row">
            <label class="new-study-label">
              Name
              <input value={entry.label} placeholder={label} maxLength={256} aria-invalid={isWrong(faults, "/label")} onInput={(event) => onChange({ ...entry, label: event.currentTarget.value })} />
            </label>
            <button onClick={addSweep}>Sweep a parameter</button>
          </div>
        </div>
      </details>
    </li>
  );
}

interface EntriesProps {
  plan: Plan;
  change: (edit: (plan: Plan) => Plan) => void;
  methods: Method[];
  devices: Device[];
  labels: string[];
  faults: Fault[];
}

export function EntriesPanel({ plan, change, methods, devices, labels, faults }: EntriesProps) {
  const edit = (entries: (old: EntryPlan[]) => EntryPlan[]) => change((old) => ({ ...old, entries: entries(old.entries) }));
  const unused = methods.find((method) => method.devices.includes("cpu") && !plan.entries.some((entry) => entry.method.name === method.name));
  return (
    <section class="panel stack" aria-labelledby="new-study-entries">
      <h2 id="new-study-entries">What is compared</h2>
      <div class="new-study-presets" role="group" aria-label="Common comparisons">
        {kPresets.map((preset) => (
          <button key={preset.id} onClick={() => change((plan) => withPreset(plan, preset))}>
            <b>{preset.name}</b>
            <small class="muted">{preset.text}</small>
          </button>
        ))}
      </div>
      <ol class="new-study-entry-list">
        {plan.entries.map((entry, index) => (
          <EntryCard
            key={entry.key}
            entry={entry}
            index={index}
            label={labels[index]!}
            alone={plan.entries.length === 1}
            methods={methods}
            devices={devices}
            faults={faultsUnder(faults, `/${index}`)}
            onChange={(next) => edit((old) => old.map((other) => (other.key === entry.key ? next : other)))}
            onCopy={() => edit((old) => old.flatMap((other) => (other.key === entry.key ? [other, entryOf(entry.method, "", entry.sweeps)] : [other])))}
            onRemove={() => edit((old) => old.filter((other) => other.key !== entry.key))}
          />
        ))}
      </ol>
      <div>
        <button onClick={() => edit((old) => [...old, entryOf({ name: unused?.name ?? old[0]!.method.name, device: "cpu", parameters: {} })])}>Add a method</button>
      </div>
      {faults
        .filter((fault) => fault.pointer === "")
        .map((fault) => (
          <p key={fault.detail} class="fault" role="alert">
            {fault.detail}
          </p>
        ))}
    </section>
  );
}

// -- budget, metrics, seeds ---------------------------------------------------------------------------------------------

export function BudgetPanel({ plan, set, faults }: { plan: Plan; set: Set; faults: Fault[] }) {
  const { stop } = plan;
  const usual = usualMetrics();
  const named = new Set(usual.map(({ name }) => name));
  const others = plan.metrics.filter((metric) => !named.has(metric));
  const setMetric = (name: string, on: boolean) =>
    set({ metrics: on ? [...usual.map(({ name: other }) => other).filter((other) => other === name || plan.metrics.includes(other)), ...others] : plan.metrics.filter((other) => other !== name) });
  return (
    <section class="panel stack" aria-labelledby="new-study-budget">
      <h2 id="new-study-budget">How long, and how it is measured</h2>
      <fieldset class="new-study-fieldset">
        <legend>Each job ends at whichever comes first</legend>
        <div class="fields">
          <NumberField label="Time" unit="s" value={stop.seconds} wrong={isWrong(faults, "/stop/seconds")} onValue={(seconds) => set({ stop: { ...stop, seconds } })} />
          <NumberField label="Passes" step="1" value={stop.passes} wrong={isWrong(faults, "/stop/passes")} onValue={(passes) => set({ stop: { ...stop, passes } })} />
          <NumberField
            label={`Error (${stop.target?.metric ?? plan.metrics[0] ?? "relative_mse"})`}
            value={stop.target?.value}
            wrong={isWrong(faults, "/stop/target")}
            onValue={(value) => set({ stop: { ...stop, target: value === null ? null : { metric: stop.target?.metric ?? plan.metrics[0] ?? "relative_mse", value } } })}
          />
        </div>
        <Faults faults={faults} at="/stop" />
      </fieldset>
      <fieldset class="new-study-fieldset">
        <legend>Errors measured; the first is the one to judge by</legend>
        <div class="new-study-metrics">
          {usual.map(({ name, line }) => (
            <label key={name}>
              <input type="checkbox" checked={plan.metrics.includes(name)} onChange={(event) => setMetric(name, event.currentTarget.checked)} />
              <span>
                {name}
                {plan.metrics[0] === name && <span class="new-study-first"> first</span>}
                <small class="muted">{line}</small>
              </span>
            </label>
          ))}
        </div>
        <label class="field new-study-others">
          Others, such as indirect:relative_mse for one layer
          <input
            defaultValue={others.join(", ")}
            autocomplete="off"
            onChange={(event) =>
              set({ metrics: [...plan.metrics.filter((metric) => named.has(metric)), ...event.currentTarget.value.split(/[,\s]+/).filter(Boolean)] })
            }
          />
        </label>
        <Faults faults={faults} at="/metrics" />
      </fieldset>
      <div class="field">
        <label for="new-study-seeds">Seeds</label>
        <input id="new-study-seeds" value={plan.seeds} autocomplete="off" aria-invalid={isWrong(faults, "/seeds")} aria-describedby="new-study-seeds-hint" onInput={(event) => set({ seeds: event.currentTarget.value })} />
        <span id="new-study-seeds-hint" class="hint">
          <Faults faults={faults} at="/seeds" /> Everything is rendered once for each: 1, 2, 3 gives intervals, and takes three times as long.
        </span>
      </div>
    </section>
  );
}

// -- reference ----------------------------------------------------------------------------------------------------------

const kReferences = [
  { kind: "render", name: "Render it", text: "in two films, whose noise drops out of squared errors" },
  { kind: "given", name: "A job or image", text: "that is there already; its noise is a part of every error" },
  { kind: "none", name: "None", text: "only estimated errors" },
] as const;

interface ReferenceProps {
  plan: Plan;
  set: Set;
  methods: Method[];
  devices: Device[];
  faults: Fault[];
}

export function ReferencePanel({ plan, set, methods, devices, faults }: ReferenceProps) {
  const { reference } = plan;
  const choose = (kind: (typeof kReferences)[number]["kind"]) =>
    set(
      kind === "render"
        ? { reference: { kind, method: { name: "path_tracing", device: "cpu", parameters: {} }, passes: 1024 } }
        : kind === "given"
          ? { reference: { kind, source: "" } }
          : { reference: { kind }, metrics: ["estimated_relative_mse"] },
    );
  return (
    <section class="panel stack" aria-labelledby="new-study-reference">
      <h2 id="new-study-reference">Reference</h2>
      <div class="row" role="radiogroup" aria-label="Reference">
        {kReferences.map((choice) => (
          <label key={choice.kind} class="new-study-choice">
            <input type="radio" name="reference" checked={reference.kind === choice.kind} onChange={() => choose(choice.kind)} />
            <span>
              {choice.name}
              <small class="muted">{choice.text}</small>
            </span>
          </label>
        ))}
      </div>
      {reference.kind === "render" && (
        <>
          <NumberField label="Passes" step="1" min={1} value={reference.passes} wrong={isWrong(faults, "/stop")} onValue={(passes) => set({ reference: { ...reference, passes: passes ?? 0 } })} />
          <Faults faults={faults} at="/stop" />
          <details class="new-study-reference-method">
            <summary>
              By {methods.find((method) => method.name === reference.method.name)?.title.toLowerCase() ?? reference.method.name} on {reference.method.device ?? "cpu"}
            </summary>
            <MethodForm
              methods={methods}
              devices={devices}
              value={reference.method}
              onChange={(method) => set({ reference: { ...reference, method } })}
              faults={faultsUnder(faults, "/method")}
              idPrefix="reference"
            />
          </details>
        </>
      )}
      {reference.kind === "given" && (
        <label class="field">
          job:J12 or image:ID
          <input value={reference.source} autocomplete="off" aria-invalid={isWrong(faults, "")} onInput={(event) => set({ reference: { kind: "given", source: event.currentTarget.value } })} />
        </label>
      )}
      {faults
        .filter((fault) => fault.pointer === "")
        .map((fault) => (
          <span key={fault.detail} class="fault" role="alert">
            {fault.detail}
          </span>
        ))}
    </section>
  );
}
