// The list of sequences, newest first.

import "./sequences.css";

import { useEffect } from "preact/hooks";

import { listen } from "../api/events";
import { isOver, type Page, type SequenceSummary } from "../api/types";
import { Title } from "../app/title";
import { percentText, plainName, secondsText, sizeText, stopText, timeText } from "../ui/format";
import { RecordTable, type RecordColumn } from "../ui/record_table";
import { useRemote } from "../ui/remote";
import { sceneName } from "../ui/scene_names";
import { StateMark } from "../ui/state";

const kMost = 200;
const kSoonMs = 1000;

const kColumns: RecordColumn[] = [
  { title: "Sequence", part: "id" },
  { title: "Scene", part: "what" },
  { title: "State", part: "state" },
  { title: "Frames", part: "figure", number: true },
  { title: "Each ends at", part: "figure" },
  { title: "Asked for", part: "when" },
];

function cellsOf(sequence: SequenceSummary) {
  const { request } = sequence;
  return [
    <a href={`/sequences/${sequence.id}`}>{sequence.id}</a>,
    <>
      {sceneName(request.scene)}
      <small class="muted">
        {plainName(request.method.name)} · {sizeText(request.image)}
      </small>
    </>,
    <>
      <StateMark state={sequence.state} />
      {!isOver(sequence.state) && (
        <span class="muted small">
          {" "}
          {percentText(sequence.progress)}
          {sequence.seconds_left !== null && `, ${secondsText(sequence.seconds_left)} left`}
        </span>
      )}
    </>,
    `${sequence.job_states.succeeded} of ${request.frames}`,
    stopText(request.stop),
    timeText(sequence.created),
  ];
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
        <div class="panel">
          <RecordTable label="Sequences" columns={kColumns} rows={data.items.map((sequence) => ({ id: sequence.id, cells: cellsOf(sequence) }))} />
        </div>
      )}
    </>
  );
}
