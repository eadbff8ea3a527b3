// The list of comparisons, newest first.

import "./studies.css";

import { useEffect, useState } from "preact/hooks";

import { getJson } from "../api/client";
import { listen } from "../api/events";
import { isOver, type Comparison, type ComparisonSummary, type Page } from "../api/types";
import { Title } from "../app/title";
import { percentText, plainName, sizeText, stopText, timeText } from "../ui/format";
import { useSeen } from "../ui/picture";
import { RecordTable, type RecordColumn } from "../ui/record_table";
import { useRemote } from "../ui/remote";
import { sceneName } from "../ui/scene_names";
import { StateMark } from "../ui/state";
import { sayFailure } from "../ui/toasts";

const kPageSize = 50;
const kSoonMs = 300;

/** What a study that is over has come to, in a sentence; asked for when its row comes into view. */
function Finding({ id }: { id: string }) {
  const [seen, watch] = useSeen<HTMLElement>();
  const { data } = useRemote<Comparison>(seen ? `/v1/comparisons/${id}` : null, true);
  const found = data?.headlines.find((headline) => headline.metric === data.request.metrics[0]);
  return (
    <small ref={watch} class="studies-finding">
      {found?.text}
    </small>
  );
}

const entriesText = (request: ComparisonSummary["request"]): string =>
  request.entries.map((entry) => entry.label ?? plainName(entry.method.name)).join(", ");

const kColumns: RecordColumn[] = [
  { title: "Study", part: "id" },
  { title: "Entries and scene", part: "what" },
  { title: "State", part: "state" },
  { title: "Each job ends at", part: "figure" },
  { title: "Seeds", part: "figure", number: true },
  { title: "Jobs", part: "figure", number: true },
  { title: "Asked for", part: "when" },
];

function cellsOf(study: ComparisonSummary) {
  const { request } = study;
  return [
    <a href={`/studies/${study.id}`}>{study.id}</a>,
    <>
      <a class="studies-name" href={`/studies/${study.id}`}>
        {request.title ?? entriesText(request)}
      </a>
      <small class="muted">
        {request.title && `${entriesText(request)} · `}
        {sceneName(request.scene)} · {sizeText(request.image)}
      </small>
      {study.state === "succeeded" && <Finding id={study.id} />}
    </>,
    <>
      <StateMark state={study.state} />
      {!isOver(study.state) && (
        <small class="studies-progress">
          <progress value={study.progress} max={1} aria-label={`Progress of ${study.id}`} /> {percentText(study.progress)}
        </small>
      )}
    </>,
    stopText(request.stop),
    request.seeds.length,
    Object.values(study.job_states).reduce((sum, count) => sum + count, 0),
    timeText(study.created),
  ];
}

function Empty() {
  return (
    <div class="panel empty">
      <p>Nothing has been compared yet. A comparison renders one scene by several methods and tells who is first to which error.</p>
      <a class="button primary" href="/studies/new">
        Compare methods
      </a>
    </div>
  );
}

export function Studies() {
  const first = useRemote<Page<ComparisonSummary>>(`/v1/comparisons?limit=${kPageSize}`);
  const [older, setOlder] = useState<{ items: ComparisonSummary[]; next: string | null } | null>(null);
  useEffect(() => {
    let timer = 0;
    const stop = listen((event) => {
      const told = event.type === "gap" || ((event.type === "state" || event.type === "progress") && event.change.id);
      if (told && !timer)
        timer = window.setTimeout(
          () => {
            timer = 0;
            first.reload();
          },
          event.type === "state" ? kSoonMs : 2000,
        );
    });
    return () => {
      clearTimeout(timer);
      stop();
    };
  }, [first.reload]);
  const next = older ? older.next : (first.data?.next_cursor ?? null);
  const more = () =>
    getJson<Page<ComparisonSummary>>("/v1/comparisons", { limit: kPageSize, cursor: next }).then(
      (page) => setOlder((old) => ({ items: [...(old?.items ?? []), ...page.items], next: page.next_cursor })),
      sayFailure,
    );
  const newest = first.data?.items ?? [];
  const known = new Set(newest.map((study) => study.id));
  const items = [...newest, ...(older?.items ?? []).filter((study) => !known.has(study.id))];
  return (
    <>
      <Title text="Studies">
        <a class="button" href="/studies/hard-cases">
          Hard cases
        </a>
        <a class="button primary" href="/studies/new">
          New comparison
        </a>
      </Title>
      {first.failure && (
        <p class="notice failed">
          {first.failure.message} <button onClick={first.reload}>Try again</button>
        </p>
      )}
      {!first.data && first.loading && (
        <p class="empty" role="status">
          Reading the list …
        </p>
      )}
      {first.data && items.length === 0 && <Empty />}
      {items.length > 0 && (
        <div class="panel">
          <RecordTable label="Comparisons" columns={kColumns} rows={items.map((study) => ({ id: study.id, cells: cellsOf(study) }))} />
          {next && (
            <p class="studies-more">
              <button onClick={() => void more()}>Older ones</button>
            </p>
          )}
        </div>
      )}
    </>
  );
}
