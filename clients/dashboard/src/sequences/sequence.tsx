// One sequence: played, stepped through, beside another one on the same clock.

import "./sequences.css";

import { useLocation, useRoute } from "preact-iso";
import { useEffect, useMemo, useState } from "preact/hooks";

import { ask, download, saveBlob, sendJson } from "../api/client";
import { isOver, type Page, type Sequence, type SequenceSummary } from "../api/types";
import { useKeys } from "../app/keyboard";
import { Title } from "../app/title";
import { useQuery } from "../app/url_state";
import { ActionButton } from "../ui/action_button";
import { percentText, plainName, secondsText, stopText } from "../ui/format";
import { useRemote } from "../ui/remote";
import { sceneName } from "../ui/scene_names";
import { StateMark } from "../ui/state";
import { sayFailure } from "../ui/toasts";
import { playSeconds, stepped } from "./clock";
import { ErrorsByFrame } from "./errors";
import { Player } from "./player";
import { useSequence } from "./use_sequence";

/** Seconds since the first frame, which run while it plays. */
function useClock(length: number) {
  const [seconds, setSeconds] = useState(0);
  const [playing, setPlaying] = useState(false);
  const [speed, setSpeed] = useState(1);
  useEffect(() => {
    if (!playing || length <= 0) return;
    let last = performance.now();
    let frame = requestAnimationFrame(function tick(now: number) {
      const passed = (speed * (now - last)) / 1000;
      last = now;
      setSeconds((old) => (old + passed) % length);
      frame = requestAnimationFrame(tick);
    });
    return () => cancelAnimationFrame(frame);
  }, [playing, length, speed]);
  return { seconds, setSeconds, playing, setPlaying, speed, setSpeed };
}

function Beside({ of, chosen, choose }: { of: Sequence; chosen: string; choose: (id: string) => void }) {
  const others = useRemote<Page<SequenceSummary>>("/v1/sequences?limit=100").data?.items ?? [];
  return (
    <label class="field">
      Beside it{" "}
      <select value={chosen} onChange={(event) => choose(event.currentTarget.value)}>
        <option value="">nothing</option>
        {others
          .filter((other) => other.id !== of.id)
          .map((other) => (
            <option key={other.id} value={other.id}>
              {other.id}: {sceneName(other.request.scene)}, {plainName(other.request.method.name)}
            </option>
          ))}
      </select>
    </label>
  );
}

function Frames({ sequence, show }: { sequence: Sequence; show: (time: number) => void }) {
  const first = sequence.frames[0]?.time ?? 0;
  return (
    <section class="panel" aria-labelledby="sequence-frames">
      <h2 id="sequence-frames">Frames</h2>
      <div class="scroll-x sequence-list" tabIndex={0} role="group" aria-label="Frames">
        <table>
          <thead>
            <tr>
              <th scope="col" class="number">Frame</th>
              <th scope="col" class="number">Moment</th>
              <th scope="col">State</th>
              <th scope="col" class="number">Rendered in</th>
              <th scope="col">Job</th>
            </tr>
          </thead>
          <tbody>
            {sequence.frames.map((frame) => (
              <tr key={frame.id}>
                <td class="number">
                  <button class="quiet" onClick={() => show(frame.time - first)}>
                    {frame.frame}
                  </button>
                </td>
                <td class="number">{frame.time.toFixed(3)} s</td>
                <td>
                  <StateMark state={frame.state} />
                </td>
                <td class="number">{secondsText(frame.seconds)}</td>
                <td>
                  <a href={`/jobs/${frame.id}`}>{frame.id}</a>
                </td>
              </tr>
            ))}
          </tbody>
        </table>
      </div>
    </section>
  );
}

function Shown({ sequence, other, reload }: { sequence: Sequence; other: Sequence | null; reload: () => void }) {
  const { route } = useLocation();
  const [query, change] = useQuery();
  const length = Math.max(playSeconds(sequence.frames, sequence.request.fps), other ? playSeconds(other.frames, other.request.fps) : 0);
  const { seconds, setSeconds, playing, setPlaying, speed, setSpeed } = useClock(length);
  const step = (frames: number) => {
    setPlaying(false);
    setSeconds((old) => stepped(sequence.frames, old, frames));
  };
  useKeys(
    "Sequence",
    [
      { key: " ", text: "play or pause", run: () => setPlaying((old) => !old) },
      { key: "ArrowRight", text: "next frame", run: () => step(1) },
      { key: "ArrowLeft", text: "frame before", run: () => step(-1) },
    ],
    [sequence],
  );
  const over = isOver(sequence.state);
  const cancel = () => sendJson("DELETE", `/v1/sequences/${sequence.id}`).then(reload);
  const remove = () => sendJson("DELETE", `/v1/sequences/${sequence.id}?purge=true`).then(() => route("/sequences"));
  const save = (images: "exr" | "png") => download(`${sequence.links.frames}?images=${images}`, `${sequence.id}-${images}.zip`).catch(sayFailure);
  const saveVideo = async () => {
    const video = await (await ask(`/v1/sequences/${sequence.id}/video`)).blob();
    saveBlob(video, `${sequence.id}.${video.type.split("/")[1]}`); // mp4, or png where the daemon has no ffmpeg
  };
  const done = sequence.job_states.succeeded;
  return (
    <>
      <Title text={`Sequence ${sequence.id}`}>
        {over ? (
          <ActionButton class="danger" busy="Removing …" until={sequence.state} run={remove}>
            Remove with its frames
          </ActionButton>
        ) : (
          <ActionButton busy="Cancelling …" until={sequence.state} run={cancel}>
            Cancel
          </ActionButton>
        )}
      </Title>
      <div class="stack">
        <section class="panel" aria-label="Playback">
          <p class="row">
            <StateMark state={sequence.state} />
            <span>
              {done} of {sequence.frames.length} frames
            </span>
            {!over && (
              <>
                <progress value={sequence.progress} max={1} aria-label="Progress" /> {percentText(sequence.progress)}
                {sequence.seconds_left !== null && <span class="muted">{secondsText(sequence.seconds_left)} left</span>}
              </>
            )}
            <span class="muted">{stopText(sequence.request.stop)} each</span>
            {done > 0 &&
              (["exr", "png"] as const).map((images) => (
                <button key={images} onClick={() => void save(images)}>
                  {images.toUpperCase()}s in a ZIP
                </button>
              ))}
            {done > 0 && <button onClick={() => void saveVideo().catch(sayFailure)}>As a video</button>}
          </p>
          <div class="sequence-players">
            <Player sequence={sequence} seconds={seconds} />
            {other && <Player key={other.id} sequence={other} seconds={seconds} />}
          </div>
          <div class="row sequence-controls">
            <button onClick={() => step(-1)} aria-label="Frame before">
              ◂
            </button>
            <button class="primary" onClick={() => setPlaying(!playing)}>
              {playing ? "Pause" : "Play"}
            </button>
            <button onClick={() => step(1)} aria-label="Next frame">
              ▸
            </button>
            <input
              type="range"
              min={0}
              max={length}
              step="any"
              value={seconds}
              aria-label="Time"
              onInput={(event) => {
                setPlaying(false);
                setSeconds(Number(event.currentTarget.value));
              }}
            />
            <label class="field">
              Speed{" "}
              <select value={String(speed)} onChange={(event) => setSpeed(Number(event.currentTarget.value))}>
                {[0.1, 0.25, 0.5, 1, 2].map((factor) => (
                  <option key={factor} value={String(factor)}>
                    {factor} ×
                  </option>
                ))}
              </select>
            </label>
            <Beside of={sequence} chosen={query.beside ?? ""} choose={(id) => change({ beside: id })} />
          </div>
        </section>
        <ErrorsByFrame sequence={sequence} />
        <Frames
          sequence={sequence}
          show={(time) => {
            setPlaying(false);
            setSeconds(time);
          }}
        />
      </div>
    </>
  );
}

export function SequencePage() {
  const { params } = useRoute();
  const [query] = useQuery();
  const found = useSequence(params.id ?? null);
  const other = useSequence(query.beside ?? null);
  const shown = useMemo(() => found.data, [found.data]);
  if (found.failure && !shown)
    return (
      <>
        <Title text={`Sequence ${params.id}`} />
        <p class="notice failed">
          {found.failure.message} <button onClick={found.reload}>Try again</button>
        </p>
      </>
    );
  if (!shown)
    return (
      <p class="empty" role="status">
        Reading the sequence …
      </p>
    );
  return <Shown key={shown.id} sequence={shown} other={query.beside ? other.data : null} reload={found.reload} />;
}
