// A form for a whole render: what it would take is seen before it is asked for.

import "./render.css";

import { useLocation } from "preact-iso";
import { useEffect, useMemo, useRef, useState } from "preact/hooks";

import { Problem, sendJson, withQuery } from "../api/client";
import { daemonStatus } from "../api/events";
import type { Device, Fault, Job, JobRequest, Method, Page, Scene } from "../api/types";
import { Title } from "../app/title";
import { cameraIn } from "../scenes/view_url";
import { bytesText, secondsText } from "../ui/format";
import { useRemote } from "../ui/remote";
import { say, sayFailure } from "../ui/toasts";
import { keepDraft, keptDraft, newKey, parseRequest, requestOfJob, requestOfQuery, shownBy } from "./draft";
import { DropRequest } from "./drop_request";
import { useJudgement, type Judgement } from "./estimate";
import { RequestForm, type Catalogue } from "./form";
import { useScenes } from "./scenes";

export function RenderPage() {
  const { query, url } = useLocation();
  const scenes = useRemote<Page<Scene>>("/v1/scenes?limit=1000");
  const methods = useRemote<Page<Method>>("/v1/methods");
  const devices = useRemote<Page<Device>>("/v1/devices");
  const from = useRemote<Job>(query.from ? `/v1/jobs/${encodeURIComponent(query.from)}` : null);
  const failure = scenes.failure ?? methods.failure ?? devices.failure ?? from.failure;
  const ready = scenes.data && methods.data && devices.data && (!query.from || from.data);
  const title = query.from || query.exr ? `Render, from ${query.from || query.exr}` : "Render";
  if (failure && !ready)
    return (
      <>
        <Title text={title} />
        <div class="panel empty">
          <p>{failure.message}</p>
          <button onClick={() => [scenes, methods, devices, from].forEach((remote) => remote.failure && remote.reload())}>Ask again</button>
        </div>
      </>
    );
  if (!ready)
    return (
      <>
        <Title text={title} />
        <p class="muted" role="status">
          Loading …
        </p>
      </>
    );
  const known: Catalogue = { scenes: scenes.data!.items, methods: methods.data!.items, devices: devices.data!.items };
  const start = from.data ? requestOfJob(from.data, known.methods) : requestOfQuery(query, cameraIn(query), known.scenes);
  return <Writing key={url} title={title} start={start} known={known} />;
}

function Estimated({ judgement }: { judgement: Judgement }) {
  const { estimate, problem, failure, asking } = judgement;
  if (failure) return <p class="notice failed">{failure.message}</p>;
  if (problem) return null;
  if (!estimate) return <p class="muted">Asking …</p>;
  const limit = daemonStatus.value?.workers.find((worker) => worker.memory_limit_bytes)?.memory_limit_bytes;
  return (
    <>
      <dl class={`facts render-estimate${asking ? " asking" : ""}`}>
        <dt>Render time</dt>
        <dd>{estimate.seconds === null ? <span class="muted">not known: this method has rendered nothing here yet</span> : `about ${secondsText(estimate.seconds)}`}</dd>
        <dt>Memory</dt>
        <dd>
          {bytesText(estimate.memory_bytes)}
          {limit ? <span class="muted"> of {bytesText(limit)}</span> : null}
        </dd>
        {estimate.device_memory_bytes !== null && (
          <>
            <dt>on the GPU</dt>
            <dd>{bytesText(estimate.device_memory_bytes)}</dd>
          </>
        )}
        {estimate.left_out && estimate.left_out.length > 0 && (
          <>
            <dt>Left out</dt>
            <dd>
              {estimate.left_out.map(({ kind, text }) => (
                <div key={kind}>{text}</div>
              ))}
            </dd>
          </>
        )}
      </dl>
      {estimate.warnings.map((warning) => (
        <p class="notice" key={warning}>
          {warning}
        </p>
      ))}
    </>
  );
}

const signed = (stops: number): string => `${stops > 0 ? "+" : ""}${stops}`.replace("-", "−");

/** Goes to the field a fault is about, if the form has one. */
function showField(pointer: string): void {
  for (let at = pointer; at; at = at.slice(0, at.lastIndexOf("/"))) {
    const field = document.querySelector<HTMLElement>(`[data-pointer="${CSS.escape(at)}"] :is(input, select, textarea)`);
    const parameter = /^\/method\/parameters\/(.+)$/.exec(at)?.[1];
    const found = field ?? (parameter ? document.getElementById(`render-method-${parameter}`) : null);
    if (!found) continue;
    found.closest("details")?.setAttribute("open", "");
    found.scrollIntoView({ block: "center" });
    return found.focus();
  }
}

function Faults({ faults, message }: { faults: Fault[]; message: string }) {
  if (faults.length === 0) return <p class="notice failed">{message}</p>;
  return (
    <div class="notice failed" role="alert">
      The daemon would refuse this:
      <ul class="render-faults">
        {faults.map((fault) => (
          <li key={fault.pointer + fault.detail}>
            <button type="button" class="quiet" onClick={() => showField(fault.pointer)}>
              {fault.pointer || "/"}
            </button>{" "}
            {fault.detail}
          </li>
        ))}
      </ul>
    </div>
  );
}

/** The request as text, which can be changed as text. */
function AsJson({ request, change }: { request: JobRequest; change: (request: JobRequest) => void }) {
  const [typed, setTyped] = useState<string | null>(null);
  const text = typed ?? JSON.stringify(request, null, 2);
  const { fault } = parseRequest(text);
  return (
    <details class="render-json">
      <summary>As JSON</summary>
      <textarea
        aria-label="The request as JSON"
        spellcheck={false}
        rows={Math.min(28, text.split("\n").length + 1)}
        value={text}
        aria-invalid={fault ? "true" : undefined}
        aria-describedby="render-json-fault"
        onInput={(event) => {
          setTyped(event.currentTarget.value);
          const read = parseRequest(event.currentTarget.value);
          if (read.request) change(read.request);
        }}
        onBlur={() => fault === null && setTyped(null)}
      />
      <div id="render-json-fault" class="fault" role="status">
        {fault}
      </div>
      <button
        type="button"
        class="small"
        onClick={() => navigator.clipboard.writeText(text).then(() => say("JSON copied."), () => sayFailure(new Error("The browser does not let the page copy.")))}
      >
        Copy
      </button>
    </details>
  );
}

function Writing({ title, start, known }: { title: string; start: JobRequest; known: Catalogue }) {
  const { route, query } = useLocation();
  const shown = shownBy(query);
  const search = useMemo(() => window.location.search, []);
  const [request, setRequest] = useState<JobRequest>(() => keptDraft(search) ?? start);
  const [refused, setRefused] = useState<Problem | null>(null);
  const [sending, setSending] = useState(false);
  const form = useRef<HTMLFormElement>(null);
  const scenes = useScenes(known.scenes, request.scene);
  const judgement = useJudgement(request);
  const changed = JSON.stringify(request) !== JSON.stringify(start);
  // The same request under the same key is the same job, however often it is sent; another request is another.
  const key = useRef({ of: "", key: "" });

  const change = (next: JobRequest) => {
    setRequest(next);
    setRefused(null);
    keepDraft(search, JSON.stringify(next) === JSON.stringify(start) ? null : next);
  };
  useEffect(() => setRefused(null), [judgement.problem]);

  const submit = async () => {
    const text = JSON.stringify(request);
    if (key.current.of !== text) key.current = { of: text, key: newKey() };
    setSending(true);
    try {
      const job = await sendJson<Job>("POST", "/v1/jobs", request, key.current.key);
      keepDraft(search, null);
      route(withQuery(`/jobs/${job.id}`, shownBy(query) ?? {}));
    } catch (failure) {
      setSending(false);
      if (failure instanceof Problem && failure.status === 422) setRefused(failure);
      else sayFailure(failure);
    }
  };
  const problem = refused ?? judgement.problem;
  const faults = problem?.faults ?? [];
  return (
    <>
      <DropRequest />
      <Title text={title}>
        {changed && (
          <button type="button" onClick={() => change(start)}>
            Start over
          </button>
        )}
      </Title>
      <form
        ref={form}
        class="render-room"
        noValidate
        onSubmit={(event) => {
          event.preventDefault();
          void submit();
        }}
        onKeyDown={(event) => {
          if (event.key === "Enter" && (event.ctrlKey || event.metaKey)) form.current?.requestSubmit();
          // Enter in a field is no submission: half a form would be rendered.
          else if (event.key === "Enter" && event.target instanceof HTMLInputElement) event.preventDefault();
        }}
      >
        <RequestForm request={request} change={change} faults={faults} known={{ ...known, scenes }} />
        <aside class="panel stack render-side" aria-label="What it takes">
          <h2>What it takes</h2>
          <Estimated judgement={judgement} />
          {problem && <Faults faults={faults} message={problem.message} />}
          <button class="primary render-submit" disabled={sending}>
            {sending ? "Sending …" : "Render"}
          </button>
          {shown && (
            <p class="hint" data-testid="shown-by">
              Its picture will be shown at {signed(Number(shown.exposure))} stops{shown.curve ? `, ${shown.curve}` : ""}, as the view was.
            </p>
          )}
          <p class="hint">
            <span class="by-mouse">Ctrl+Enter. </span>What you changed is kept in this tab until it is rendered.
          </p>
          <AsJson request={request} change={change} />
        </aside>
      </form>
    </>
  );
}
