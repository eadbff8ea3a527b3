// New comparison: a scene, what is compared on it, and for how long. Everything has a default, so that who only wants to
// see two methods beside each other presses one button.

import "./new_study.css";

import { useLocation } from "preact-iso";
import { useEffect, useMemo, useRef, useState } from "preact/hooks";

import { getJson, Problem, sendJson } from "../api/client";
import type { Comparison, ComparisonEstimate, ComparisonRequest, Device, Fault, Method, Page, Scene } from "../api/types";
import { Title } from "../app/title";
import { useQuery } from "../app/url_state";
import { cameraIn } from "../scenes/view_url";
import { bytesText, secondsText } from "../ui/format";
import { useRemote } from "../ui/remote";
import { say, sayFailure } from "../ui/toasts";
import { BudgetPanel, EntriesPanel, FaultList, ReferencePanel, ScenePanel } from "./new_study_parts";
import { kManyBounces, unequalBounces, withBounces } from "./bounces";
import { defaultPlan, faultsUnder, kPresets, labelsOf, type Plan, planOf, readPlan, requestOf, withPreset } from "./plan";
import { rowName } from "./series";

const kStoredPlan = "photond.comparison";
const kEstimateAfterMs = 350;

interface Estimated {
  estimate: ComparisonEstimate | null;
  faults: Fault[];
  failure: string | null;
  asking: boolean;
}

/** What the daemon says of a request, asked anew a moment after it has changed. */
function useEstimate(request: ComparisonRequest | null): Estimated {
  const [state, setState] = useState<Estimated>({ estimate: null, faults: [], failure: null, asking: true });
  const body = request ? JSON.stringify(request) : null;
  useEffect(() => {
    if (!body) return;
    let current = true;
    setState((old) => ({ ...old, asking: true }));
    const timer = window.setTimeout(() => {
      sendJson<ComparisonEstimate>("POST", "/v1/comparisons?dry_run=true", JSON.parse(body)).then(
        (estimate) => current && setState({ estimate, faults: [], failure: null, asking: false }),
        (failure: Error) => {
          if (!current) return;
          const faults = failure instanceof Problem ? failure.faults : [];
          setState({ estimate: null, faults, failure: failure.message, asking: false });
        },
      );
    }, kEstimateAfterMs);
    return () => {
      current = false;
      clearTimeout(timer);
    };
  }, [body]);
  return state;
}

/** The plan: of the comparison it repeats, of the session, or the default; and kept in the session. */
function usePlan(): [Plan | null, (change: (plan: Plan) => Plan) => void, string | null] {
  const [query, changeQuery] = useQuery();
  const [plan, setPlan] = useState<Plan | null>(null);
  const [failure, setFailure] = useState<string | null>(null);
  useEffect(() => {
    if (query.from) {
      getJson<Comparison>(`/v1/comparisons/${encodeURIComponent(query.from)}`).then(
        (comparison) => setPlan(planOf(comparison.request)),
        (reason: Error) => {
          setFailure(`${query.from} cannot be repeated: ${reason.message}`);
          setPlan(defaultPlan());
        },
      );
      return;
    }
    if (plan) return; // it has been edited, and the address no longer says where it came from
    const stored = readPlan(sessionStorage.getItem(kStoredPlan));
    const begun = stored ?? defaultPlan();
    const preset = kPresets.find((other) => other.id === query.preset);
    // A link that names a scene says where it is seen from too, or leaves that to the scene.
    const more = query.scene ? { ...begun.more, camera: cameraIn(query) ?? undefined } : begun.more;
    const next = { ...begun, scene: query.scene ?? begun.scene, more };
    setPlan(preset ? withPreset(next, preset) : next);
  }, [query.from]);
  useEffect(() => {
    if (plan) sessionStorage.setItem(kStoredPlan, JSON.stringify(plan));
  }, [plan]);
  const change = (edit: (plan: Plan) => Plan) => {
    setPlan((old) => old && edit(old));
    // What is edited is no longer what the link said; the session has it from here on.
    if (query.from || query.preset || query.scene) changeQuery({ from: null, preset: null, scene: null, camera: null, eye: null, target: null, yfov: null });
  };
  return [plan, change, failure];
}

interface SummaryProps {
  request: ComparisonRequest;
  /** What makes it unfair, and how that is mended. */
  unequal: string[];
  onEqual: () => void;
  estimated: Estimated;
  sending: boolean;
  onGo: () => void;
  onReset: () => void;
}

function Summary({ request, unequal, onEqual, estimated, sending, onGo, onReset }: SummaryProps) {
  const { estimate, faults, failure, asking } = estimated;
  const blocked = !asking && failure !== null;
  const text = JSON.stringify(request, null, 2);
  return (
    <section class="panel new-study-summary" aria-labelledby="new-study-estimate">
      <h2 id="new-study-estimate">What it will take</h2>
      <div aria-live="polite" class={asking ? "new-study-asking" : undefined}>
        {estimate ? (
          <>
            <p class="new-study-total">
              {estimate.seconds === null
                ? "Time not known yet"
                : `About ${secondsText(estimate.seconds + (estimate.reference_seconds ?? 0))}${estimate.reference_seconds === null ? " and the reference" : ""}`}
            </p>
            <dl class="facts">
              <dt>Jobs</dt>
              <dd>{estimate.jobs}</dd>
              <dt>Rendering</dt>
              <dd>{estimate.seconds === null ? "not known: nothing like it has been rendered here" : secondsText(estimate.seconds)}</dd>
              <dt>Reference</dt>
              <dd>
                {request.reference === null
                  ? "none"
                  : estimate.reference_seconds !== null
                    ? estimate.reference_seconds === 0
                      ? "is there already"
                      : secondsText(estimate.reference_seconds)
                    : "not known yet"}
              </dd>
              <dt>Memory</dt>
              <dd>{bytesText(estimate.memory_bytes)} at most</dd>
            </dl>
            {estimate.warnings.map((warning) => (
              <p class="notice" key={warning}>
                {warning}
              </p>
            ))}
            <div class="scroll-x" tabIndex={0} role="group" aria-label="Estimate of each entry">
              <table class="new-study-estimates">
                <thead>
                  <tr>
                    <th scope="col">Entry</th>
                    <th scope="col" class="number">Time</th>
                    <th scope="col" class="number">Memory</th>
                  </tr>
                </thead>
                <tbody>
                  {estimate.entries.map((entry, i) => (
                    <tr key={i}>
                      <td>{rowName(entry)}</td>
                      <td class="number">{secondsText(entry.seconds)}</td>
                      <td class="number">{bytesText(entry.memory_bytes)}</td>
                    </tr>
                  ))}
                </tbody>
              </table>
            </div>
          </>
        ) : failure ? (
          <div class="notice failed">
            {faults.length === 0 ? failure : `${faults.length === 1 ? "One thing is" : `${faults.length} things are`} wrong:`}
            <FaultList faults={faults} />
          </div>
        ) : (
          <p class="muted">Asking the daemon …</p>
        )}
      </div>
      {unequal.length > 0 && (
        <div class="notice">
          {unequal.join(" ")} What is missing stays as error.
          <p>
            <button onClick={onEqual}>Give all {kManyBounces} bounces</button>
          </p>
        </div>
      )}
      <button class="primary new-study-go" disabled={sending || blocked} onClick={onGo}>
        {sending ? "Sending …" : "Compare"}
      </button>
      <details>
        <summary>As JSON</summary>
        <pre class="new-study-json" tabIndex={0} aria-label="The request as JSON">
          {text}
        </pre>
        <button onClick={() => navigator.clipboard.writeText(text).then(() => say("Copied."), sayFailure)}>Copy</button>
      </details>
      <button class="quiet" onClick={onReset}>
        Begin anew
      </button>
    </section>
  );
}

export function NewStudy() {
  const { route } = useLocation();
  const methods = useRemote<{ items: Method[] }>("/v1/methods");
  const devices = useRemote<{ items: Device[] }>("/v1/devices");
  const scenes = useRemote<Page<Scene>>("/v1/scenes?limit=1000");
  const [plan, change, planFailure] = usePlan();
  const [sending, setSending] = useState(false);
  const [sent, setSent] = useState<Fault[]>([]);
  const known = methods.data?.items ?? null;
  const request = useMemo(() => (plan && known ? requestOf(plan, known) : null), [plan, known]);
  const estimated = useEstimate(request);
  // The same key for the same body: a second press, or one after a lost connection, does not compare twice.
  const key = useRef<{ body: string; key: string } | null>(null);
  useEffect(() => setSent([]), [request]);

  const go = async () => {
    const body = JSON.stringify(request);
    if (key.current?.body !== body) key.current = { body, key: crypto.randomUUID() };
    setSending(true);
    try {
      const comparison = await sendJson<Comparison>("POST", "/v1/comparisons", request, key.current.key);
      sessionStorage.removeItem(kStoredPlan);
      route(`/studies/${comparison.id}`);
    } catch (failure) {
      if (failure instanceof Problem) setSent(failure.faults);
      sayFailure(failure);
      setSending(false);
    }
  };
  const failure = methods.failure ?? devices.failure ?? scenes.failure;
  const title = <Title text="New comparison" />;
  if (failure && !(known && devices.data && scenes.data))
    return (
      <>
        {title}
        <p class="notice failed">
          {failure.message}{" "}
          <button
            onClick={() => {
              methods.reload();
              devices.reload();
              scenes.reload();
            }}
          >
            Try again
          </button>
        </p>
      </>
    );
  if (!plan || !known || !devices.data || !request)
    return (
      <>
        {title}
        <p class="empty" role="status">
          Asking what this daemon can render …
        </p>
      </>
    );
  const faults = sent.length > 0 ? sent : estimated.faults;
  const set = (members: Partial<Plan>) => change((old) => ({ ...old, ...members }));
  return (
    <>
      {title}
      {planFailure && <p class="notice failed">{planFailure}</p>}
      <div class="new-study-columns">
        <div class="stack">
          <ScenePanel plan={plan} set={set} scenes={scenes.data?.items ?? []} faults={faults} />
          <EntriesPanel plan={plan} change={change} methods={known} devices={devices.data.items} labels={labelsOf(plan, known)} faults={faultsUnder(faults, "/entries")} />
          <BudgetPanel plan={plan} set={set} faults={faults} />
          <ReferencePanel plan={plan} set={set} methods={known} devices={devices.data.items} faults={faultsUnder(faults, "/reference")} />
        </div>
        <Summary
          request={request}
          unequal={unequalBounces(request, known)}
          onEqual={() =>
            change((old) => ({
              ...old,
              entries: old.entries.map((entry) => ({ ...entry, method: withBounces(entry.method, kManyBounces, known) })),
              reference: old.reference.kind === "render" ? { ...old.reference, method: withBounces(old.reference.method, kManyBounces, known) } : old.reference,
            }))
          }
          estimated={{ ...estimated, faults }}
          sending={sending}
          onGo={() => void go()}
          onReset={() => change(() => defaultPlan())}
        />
      </div>
    </>
  );
}
