// The form of a whole request, part by part.

import type { Device, Fault, JobRequest, LookAt, Method, MethodChoice, Reference, Scene, StopConditions, Vec3 } from "../api/types";
import { metrics, targetMetrics } from "../api/vocabulary";
import { ByPointer } from "../ui/by_pointer";
import { aspectText, boundedAspect, kPixelChoices, sizeOfAspect } from "../ui/aspect";
import { numberText, plainName } from "../ui/format";
import { MethodForm } from "../ui/method_form";
import { Picture } from "../ui/picture";
import { StopFields } from "../ui/stop_fields";
import { aspectOfCamera, cameraChoice, faultsBelow, faultsWithin, inShapeOfCamera, kSameShape, labelsOf, labelsText, withInner, withMember } from "./draft";
import { FaultLines, Labelled, NumberField, TextField, Ticks } from "./fields";
import { animationOf, atRest, hasMoment, withMoment } from "./moment";
import { MomentPart } from "./moment_part";
import { Panel } from "./panel";
import { sceneNamed } from "./scenes";
import { useEffect, useRef, useState } from "preact/hooks";

export interface Catalogue {
  scenes: Scene[];
  methods: Method[];
  devices: Device[];
}

interface Props {
  request: JobRequest;
  change: (request: JobRequest) => void;
  faults: Fault[];
  known: Catalogue;
}

/** Offered where neither the camera nor the image has another shape. */
const kSizes: [number, number][] = [[256, 256], [512, 512], [1024, 1024], [1280, 720], [1920, 1080]];
/** Those that a job has to name. */
const metricsOnRequest = (): string[] => metrics.value.filter(({ values, on_request }) => values === 1 && on_request).map(({ name }) => name);

const kAxes = ["x", "y", "z"];

function Vector({ label, id, pointer, value, faults, onValue }: { label: string; id: string; pointer: string; value: Vec3; faults: Fault[]; onValue: (value: Vec3) => void }) {
  return (
    <fieldset class="render-vector">
      <legend>{label}, m</legend>
      {kAxes.map((axis, index) => (
        <NumberField
          key={axis}
          label={axis}
          id={`${id}-${axis}`}
          pointer={`${pointer}/${index}`}
          faults={faults}
          value={value[index]}
          onValue={(number) => onValue(value.map((old, other) => (other === index ? number : old)) as Vec3)}
        />
      ))}
      <FaultLines faults={faults.filter((fault) => fault.pointer === pointer)} />
    </fieldset>
  );
}

function ScenePart({ request, change, faults, known }: Props) {
  const scene = sceneNamed(known.scenes, request.scene);
  const cameras = scene?.cameras ?? [];
  const choice = cameraChoice(request, cameras);
  const lookAt = request.camera?.look_at;
  // A view of one's own starts where the chosen camera stands.
  const ownView = (): LookAt => {
    const from = cameras.find(({ name }) => name === choice)?.look_at ?? scene?.default_view;
    const round = (vector: Vec3) => vector.map((x) => Number(x.toPrecision(6))) as Vec3;
    return from
      ? { eye: round(from.eye), target: round(from.target), up: round(from.up), yfov: Number(from.yfov.toPrecision(6)) }
      : { eye: [0, 1, 5], target: [0, 1, 0] };
  };
  const choose = (name: string) => {
    const lens = { aperture: request.camera?.aperture, focus_distance: request.camera?.focus_distance };
    const next = withInner({ ...request, camera: null }, "camera", name === "own" ? { ...lens, look_at: ownView() } : { ...lens, name: name === cameras[0]?.name ? null : name });
    change(inShapeOfCamera(next, known.scenes));
  };
  const setLook = (part: Partial<LookAt>) => change(withInner(request, "camera", { look_at: { ...lookAt!, ...part } }));
  return (
    <Panel title="Scene">
      <div class="render-scene">
        <div class="render-thumbnail">
          {scene && <Picture path={`/v1/scenes/${encodeURIComponent(scene.id)}/thumbnail.png`} alt={`The scene ${scene.name}`} ratio={4 / 3} />}
          <span class="hint">A preview, filtered</span>
        </div>
        <div class="stack">
          <Labelled label="Scene" id="render-scene-choice" pointer="/scene" faults={faults} hint={scene ? `${numberText(scene.triangles ?? 0, 6)} triangles` : undefined}>
            {(aria) => (
              <select {...aria} value={scene?.id ?? request.scene} onChange={(event) => change(inShapeOfCamera(withMember(withMember(atRest(request), "camera", null), "scene", event.currentTarget.value), known.scenes))}>
                {!scene && <option value={request.scene}>{request.scene}</option>}
                {known.scenes.map(({ id, name }) => (
                  <option key={id} value={id}>
                    {name}
                  </option>
                ))}
              </select>
            )}
          </Labelled>
          <Labelled label="Camera" id="render-camera" pointer="/camera" faults={faults.filter((fault) => !fault.pointer.startsWith("/camera/look_at/"))}>
            {(aria) => (
              <select {...aria} value={choice} onChange={(event) => choose(event.currentTarget.value)}>
                {cameras.length === 0 && <option value="">framed on the scene</option>}
                {cameras.map(({ name }) => (
                  <option key={name} value={name}>
                    {name}
                  </option>
                ))}
                {choice !== "own" && choice !== "" && !cameras.some(({ name }) => name === choice) && <option value={choice}>{choice}</option>}
                <option value="own">a view of its own</option>
              </select>
            )}
          </Labelled>
          <p class="hint">
            <a href={`/scenes/${encodeURIComponent(request.scene)}`}>Look about in the scene</a> to choose a view <ByPointer mouse="with the mouse" finger="with a finger" />.
          </p>
        </div>
      </div>
      {lookAt && (
        <div class="render-look">
          <Vector label="Eye" id="render-eye" pointer="/camera/look_at/eye" value={lookAt.eye} faults={faults} onValue={(eye) => setLook({ eye })} />
          <Vector label="Target" id="render-target" pointer="/camera/look_at/target" value={lookAt.target} faults={faults} onValue={(target) => setLook({ target })} />
          <Vector label="Up" id="render-up" pointer="/camera/look_at/up" value={lookAt.up ?? [0, 1, 0]} faults={faults} onValue={(up) => setLook({ up })} />
          <NumberField
            label="Vertical field of view"
            id="render-yfov"
            pointer="/camera/look_at/yfov"
            faults={faults}
            value={lookAt.yfov ?? 0.7}
            unit="rad"
            hint={lookAt.yfov ? `${numberText((lookAt.yfov * 180) / Math.PI)}°` : undefined}
            onValue={(yfov) => setLook({ yfov: (yfov ?? undefined) as number })}
          />
        </div>
      )}
    </Panel>
  );
}

function ImagePart({ request, change, faults, known }: Props) {
  const { width, height } = request.image;
  const set = (image: Record<string, unknown>) => change({ ...request, image: { ...request.image, ...image } });
  const wanted = aspectOfCamera(request, known.scenes);
  const own = Number(width) > 0 && Number(height) > 0 ? width / height : null;
  const follows = wanted !== null && own !== null && Math.abs(own / wanted - 1) < kSameShape;
  const [kept, setKept] = useState(own !== null && own !== 1);
  // One side follows the other while the shape is kept; what is no number is left for the daemon to name.
  const shape = useRef(own ?? 1);
  if (!kept && own !== null) shape.current = own;
  const setSide = (name: "width" | "height", value: unknown) => {
    if (!kept || typeof value !== "number" || !(value >= 1)) return set({ [name]: value });
    const aspect = follows ? wanted : shape.current;
    set(name === "width" ? { width: value, height: Math.max(1, Math.round(value / aspect)) } : { height: value, width: Math.max(1, Math.round(value * aspect)) });
  };
  const offered: [number, number][] =
    wanted === null && (own === null || !kept)
      ? kSizes
      : kPixelChoices.map((pixels) => {
          const size = sizeOfAspect(boundedAspect(wanted ?? shape.current), pixels);
          return [size.width, size.height];
        });
  return (
    <Panel title="Image">
      <div class="row render-sizes" role="group" aria-label="Sizes">
        {offered.map(([w, h]) => (
          <button key={`${w} ${h}`} type="button" class="small" aria-pressed={w === width && h === height} onClick={() => set({ width: w, height: h })}>
            {w} × {h}
          </button>
        ))}
      </div>
      <div class="fields">
        <NumberField label="Width" id="render-width" pointer="/image/width" faults={faults} value={width} unit="pixels" onValue={(value) => setSide("width", value)} />
        <NumberField label="Height" id="render-height" pointer="/image/height" faults={faults} value={height} unit="pixels" onValue={(value) => setSide("height", value)} />
      </div>
      <div class="row">
        <label class="row">
          <input
            type="checkbox"
            checked={kept}
            onChange={(event) => {
              if (own !== null) shape.current = own;
              setKept(event.currentTarget.checked);
            }}
          />
          Keep the shape{own !== null && `, ${aspectText(own)}`}
        </label>
        {wanted !== null && !follows && (
          <button type="button" class="small" onClick={() => change(inShapeOfCamera(request, known.scenes))}>
            Take the camera’s, {aspectText(wanted)}
          </button>
        )}
      </div>
      <p class="hint" data-testid="shape">
        {wanted === null
          ? "The camera asks for no shape of the image: its field of view is the height’s, and the width shows what lies beside."
          : follows
            ? `The size follows the camera, whose file asks for ${aspectText(wanted)}.`
            : `The camera’s file asks for ${aspectText(wanted)}: this image shows more at its sides, or less.`}
      </p>
      <FaultLines faults={faults.filter((fault) => fault.pointer === "/image")} />
    </Panel>
  );
}

const kReferenceKinds = { none: "none: the error is estimated", named: "a job or an uploaded image", made: "rendered for this once, and kept" };
type ReferenceKind = keyof typeof kReferenceKinds;

function ReferencePart({ request, change, faults, known }: Props) {
  const { reference } = request;
  const kind: ReferenceKind = typeof reference === "string" ? "named" : reference ? "made" : "none";
  const set = (next: Reference | null) => {
    const changed = withMember(request, "reference", next);
    // Without a reference neither metrics nor targets by them mean anything.
    if (next) return change(changed);
    const target = request.stop.target && !targetMetrics(false).includes(request.stop.target.metric) ? null : request.stop.target;
    const { target: _, ...stop } = request.stop;
    change(withMember({ ...changed, stop: target ? { ...stop, target } : stop }, "metrics", null));
  };
  const choose = (next: ReferenceKind) => {
    if (next === "none") return set(null);
    // A job's number is still to be given: until then the daemon says so.
    if (next === "named") return set("job:");
    set({ method: { name: "path_tracing" }, stop: { passes: 1024 } });
  };
  const made = kind === "made" ? (reference as { method: MethodChoice; stop: StopConditions }) : null;
  return (
    <Panel title="Reference and metrics" note="how far the image is from the truth">
      <Labelled label="Reference" id="render-reference" pointer="/reference" faults={kind === "made" ? faults.filter((fault) => fault.pointer === "/reference") : faults}>
        {(aria) => (
          <select {...aria} value={kind} onChange={(event) => choose(event.currentTarget.value as ReferenceKind)}>
            {Object.entries(kReferenceKinds).map(([value, text]) => (
              <option key={value} value={value}>
                {text}
              </option>
            ))}
          </select>
        )}
      </Labelled>
      {kind === "named" && (
        <TextField
          label="Which"
          id="render-reference-name"
          pointer="/reference"
          faults={[]}
          value={reference as string}
          placeholder="job:J17 or image:ID"
          hint="job:J17, or image:ID of an uploaded one"
          onValue={(value) => set(value || "job:")}
        />
      )}
      {made && (
        <div class="render-inner">
          <MethodForm
            methods={known.methods}
            devices={known.devices}
            value={made.method}
            onChange={(method) => set({ ...made, method })}
            faults={faultsWithin(faults, "/reference/method")}
            idPrefix="render-reference-method"
          />
          <StopFields value={made.stop} onChange={(stop) => set({ ...made, stop })} metrics={targetMetrics(false)} faults={faults} idPrefix="render-reference-stop" pointer="/reference/stop" />
        </div>
      )}
      {reference && (
        <Ticks
          legend="Measured besides what costs little"
          words={metricsOnRequest()}
          chosen={request.metrics ?? []}
          onChosen={(metrics) => change(withMember(request, "metrics", metrics))}
          faults={faultsBelow(faults, "/metrics")}
        />
      )}
    </Panel>
  );
}

function More({ request, change, faults }: Props) {
  const [labels, setLabels] = useState<string | null>(null);
  const environment = request.environment;
  const set = (name: string) => (value: unknown) => change(withMember(request, name, value));
  const pointers = ["/seed", "/priority", "/labels", "/glass", "/environment", "/camera/aperture", "/camera/focus_distance", "/image/filter", "/first_pass", "/shutter"];
  const said = ["seed", "priority", "labels", "glass", "environment", "shutter"].filter((name) => request[name] !== undefined).length + (request.image.filter ? 1 : 0);
  const moves = animationOf(request) !== null;
  const wrong = pointers.some((pointer) => faultsBelow(faults, pointer).length > 0);
  // Opened by a fault, it stays so once that is mended: one may still be writing in it.
  const [open, setOpen] = useState(wrong);
  useEffect(() => {
    if (wrong) setOpen(true);
  }, [wrong]);
  return (
    <details class="panel render-more" open={open} onToggle={(event) => setOpen(event.currentTarget.open)}>
      <summary>
        <h2>More</h2>
        <span class="hint">seed, priority, labels, pixel filter, lens, {moves && "shutter, "}environment, glass</span>
        {said > 0 && <span class="method-form-count">{said} set</span>}
      </summary>
      <div class="fields">
        <NumberField label="Seed" id="render-seed" pointer="/seed" faults={faults} value={request.seed} placeholder="1" hint="another seed, other noise" onValue={set("seed")} />
        <NumberField label="Priority" id="render-priority" pointer="/priority" faults={faults} value={request.priority} placeholder="0" hint="−100 to 100, higher first" onValue={set("priority")} />
        <Labelled label="Pixel filter" id="render-filter" pointer="/image/filter" faults={faults}>
          {(aria) => (
            <select
              {...aria}
              value={request.image.filter ?? "box"}
              onChange={(event) => {
                const { filter: _, ...image } = request.image;
                const filter = event.currentTarget.value;
                change({ ...request, image: filter === "box" ? image : { ...image, filter } });
              }}
            >
              {["box", "gaussian", "blackman_harris"].map((name) => (
                <option key={name} value={name}>
                  {plainName(name)}
                </option>
              ))}
            </select>
          )}
        </Labelled>
        <Labelled label="Glass" id="render-glass" pointer="/glass" faults={faults} hint="what transmits light is a thin sheet, or filled">
          {(aria) => (
            <select {...aria} value={(request.glass as string | undefined) ?? "as_stored"} onChange={(event) => set("glass")(event.currentTarget.value === "as_stored" ? null : event.currentTarget.value)}>
              <option value="as_stored">as the scene has it</option>
              <option value="solid">solid</option>
            </select>
          )}
        </Labelled>
        <NumberField
          label="Lens radius"
          id="render-aperture"
          pointer="/camera/aperture"
          faults={faults}
          value={request.camera?.aperture}
          unit="m"
          placeholder="0, all in focus"
          onValue={(aperture) => change(withInner(request, "camera", { aperture }))}
        />
        <NumberField
          label="Focus distance"
          id="render-focus"
          pointer="/camera/focus_distance"
          faults={faults}
          value={request.camera?.focus_distance}
          unit="m"
          placeholder="at the target"
          onValue={(focus_distance) => change(withInner(request, "camera", { focus_distance }))}
        />
        {moves && (
          <NumberField
            label="Shutter"
            id="render-shutter"
            pointer="/shutter"
            faults={faults}
            value={request.shutter}
            unit="s"
            placeholder="0, all at one moment"
            hint="open for so long: each pass shows a moment within it"
            onValue={(shutter) => change(withMoment(request, "shutter", shutter))}
          />
        )}
        <TextField
          label="Environment"
          id="render-environment"
          pointer="/environment"
          faults={faults}
          value={environment?.image ?? ""}
          placeholder="image:ID of an uploaded one"
          hint="light from all about, by an EXR or HDR image"
          onValue={(image) => change(image ? withInner(request, "environment", { image }) : withMember(request, "environment", null))}
        />
        {environment && (
          <>
            <NumberField label="Environment's scale" id="render-environment-scale" pointer="/environment/scale" faults={faults} value={environment.scale} placeholder="1" onValue={(scale) => change(withInner(request, "environment", { scale }))} />
            <NumberField label="Environment's rotation" id="render-environment-rotation" pointer="/environment/rotation" faults={faults} value={environment.rotation} unit="rad" placeholder="0" onValue={(rotation) => change(withInner(request, "environment", { rotation }))} />
          </>
        )}
        <Labelled label="Labels" id="render-labels" pointer="/labels" faults={faults} hint="one a line, KEY=VALUE, to find the job by">
          {(aria) => (
            <textarea
              {...aria}
              rows={2}
              spellcheck={false}
              value={labels ?? labelsText(request.labels)}
              onInput={(event) => {
                setLabels(event.currentTarget.value);
                change(withMember(request, "labels", labelsOf(event.currentTarget.value)));
              }}
              onBlur={() => setLabels(null)}
            />
          )}
        </Labelled>
      </div>
    </details>
  );
}

export function RequestForm(props: Props) {
  const { request, change, faults, known } = props;
  const method = known.methods.find(({ name }) => name === request.method.name);
  const scene = sceneNamed(known.scenes, request.scene);
  return (
    <div class="stack">
      <ScenePart {...props} />
      {hasMoment(request, scene) && <MomentPart request={request} change={change} faults={faults} scene={scene} />}
      <ImagePart {...props} />
      <Panel title="Method">
        <MethodForm
          methods={known.methods}
          devices={known.devices}
          value={request.method}
          onChange={(chosen) => {
            // Layers that the other method does not have would be refused.
            const layers = known.methods.find(({ name }) => name === chosen.name)?.layers;
            const kept = layers ? (request.layers ?? []).filter((layer) => layers.includes(layer)) : request.layers;
            change(withMember({ ...request, method: said(chosen) }, "layers", kept));
          }}
          faults={faultsWithin(faults, "/method")}
          idPrefix="render-method"
        />
      </Panel>
      <Panel title="When it ends" note="the first that is met">
        <StopFields value={request.stop} onChange={(stop) => change({ ...request, stop })} metrics={targetMetrics(Boolean(request.reference))} faults={faults} idPrefix="render-stop" />
      </Panel>
      <ReferencePart {...props} />
      {(method?.layers?.length ?? 0) > 0 && (
        <Panel title="Layers" note="kept beside the image, in the EXR">
          <Ticks
            legend="Besides emitted, direct and indirect light"
            words={method!.layers!}
            chosen={request.layers ?? []}
            onChosen={(layers) => change(withMember(request, "layers", layers))}
            faults={faultsBelow(faults, "/layers")}
          />
        </Panel>
      )}
      <More {...props} />
    </div>
  );
}

/** A choice of method without members that say nothing. */
function said({ parameters, device, name }: MethodChoice): MethodChoice {
  return { name, ...(device && device !== "cpu" ? { device } : {}), ...(parameters && Object.keys(parameters).length > 0 ? { parameters } : {}) };
}
