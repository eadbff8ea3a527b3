// The list of sequences, newest first.

import "./sequences.css";

import { useEffect } from "preact/hooks";

import { listen } from "../api/events";
import { isOver, type Page, type SequenceSummary } from "../api/types";
import { Title } from "../app/title";
import { percentText, plainName, secondsText, sizeText, stopText, timeText } from "../ui/format";
import { useRemote } from "../ui/remote";
import { sceneName } from "../ui/scene_names";
import { StateMark } from "../ui/state";

const kMost = 200;
const kSoonMs = 1000;

function Row({ sequence }: { sequence: SequenceSummary }) {
  const { request } = sequence;
  return (
    <tr>
      <td>
        <a href={`/sequences/${sequence.id}`}>{sequence.id}</a>
      </td>
      <td>
        {sceneName(request.scene)}
        <small class="muted sequences-more">
          {plainName(request.method.name)} · {sizeText(request.image)}
        </small>
      </td>
      <td>
        <StateMark state={sequence.state} />
        {!isOver(sequence.state) && (
          <small class="muted">
            {" "}
            {percentText(sequence.progress)}
            {sequence.seconds_left !== null && `, ${secondsText(sequence.seconds_left)} left`}
          </small>
        )}
      </td>
      <td class="number">
        {sequence.job_states.succeeded} of {request.frames}
      </td>
      <td>{stopText(request.stop)}</td>
      <td>{timeText(sequence.created)}</td>
    </tr>
  );
}

export function Sequences() {
  const { data, failure, loading, reload } = useRemote<Page<SequenceSummary>>(`/v1/sequences?limit=${kMost}`);
  useEffect(() => {
    let timer = 0;
    const stop = listen((event) => {
      if (event.type !== "status" && !timer) timer = window.setTimeout(() => ((timer = 0), reload()), kSoonMs);
    });
    return () => {
      clearTimeout(timer);
      stop();
    };
  }, [reload]);
  return (
    <>
      <Title text="Sequences" />
      {failure && (
        <p class="notice failed">
          {failure.message} <button onClick={reload}>Try again</button>
        </p>
      )}
      {!data && loading && (
        <p class="empty" role="status">
          Reading the list …
        </p>
      )}
      {data?.items.length === 0 && (
        <div class="panel empty">
          <p>Nothing has been rendered frame by frame yet. A sequence shows a moving scene, or a still one along a path of the camera:</p>
          <p class="mono">photonctl sequence moving/cornell-box --to 4 --passes 16</p>
        </div>
      )}
      {data && data.items.length > 0 && (
        <div class="panel scroll-x" tabIndex={0} role="group" aria-label="Sequences">
          <table>
            <thead>
              <tr>
                <th scope="col">Sequence</th>
                <th scope="col">Scene</th>
                <th scope="col">State</th>
                <th scope="col" class="number">Frames</th>
                <th scope="col">Each ends at</th>
                <th scope="col">Asked for</th>
              </tr>
            </thead>
            <tbody>
              {data.items.map((sequence) => (
                <Row key={sequence.id} sequence={sequence} />
              ))}
            </tbody>
          </table>
        </div>
      )}
    </>
  );
}
