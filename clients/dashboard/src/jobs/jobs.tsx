// All jobs there are, to be found, looked at and steered, one or many at a time.

import "./jobs.css";

import { useLocation } from "preact-iso";
import { useEffect, useMemo, useRef, useState } from "preact/hooks";

import { connection } from "../api/events";
import { isOver, type JobSummary } from "../api/types";
import { useKeys, type Key } from "../app/keyboard";
import { Title } from "../app/title";
import { useQuery } from "../app/url_state";
import { DropRequest } from "../render/drop_request";
import { say, sayFailure } from "../ui/toasts";
import { clampPriority, doTo, jobsText, kActionWords, statesFor, type BulkAction } from "./bulk";
import { BulkDialog, type Targets } from "./bulk_dialog";
import { filterOfQuery, filterText, queryOfFilter, type Filter } from "./filter";
import { FilterBar } from "./filter_bar";
import { JobGrid, type GridControl } from "./job_grid";
import type { JobList } from "./job_list";
import { kNothing, renewed, toggled, withJobs, type Selection } from "./selection";
import { useJobList, useStateCounts, useVocabulary } from "./use_jobs";

const kMostCompared = 9;
const kPriorityStep = 10;
const kPlaceKey = "photond.jobs.place";

/** Where the list was left, for whoever comes back to it. */
function placeLeft(): { scrollTop: number; active: number } {
  try {
    const left = JSON.parse(sessionStorage.getItem(kPlaceKey) ?? "null") as { at: string; scrollTop: number; active: number } | null;
    if (left?.at === window.location.search) return left;
  } catch {
    // something else's
  }
  return { scrollTop: 0, active: 0 };
}

export function Jobs() {
  const [query, setQuery] = useQuery();
  const filter = useMemo(() => filterOfQuery(query), [JSON.stringify(query)]);
  const list = useJobList(filter);
  const input = useRef<HTMLInputElement | null>(null);
  const grid = useRef<GridControl | null>(null);
  const setFilter = (next: Filter) => setQuery(queryOfFilter(next));
  return (
    <div class="jobs-room">
      <Title text="Jobs">
        <Total list={list} filtered={filterText(filter) !== ""} />
      </Title>
      <FilterBar
        filter={filter}
        vocabulary={useVocabulary(list)}
        counts={useStateCounts(filter)}
        onFilter={setFilter}
        input={input}
        onLeave={() => grid.current?.focus()}
      />
      <JobsOf key={filterText(filter)} filter={filter} list={list} onFilter={setFilter} input={input} grid={grid} />
    </div>
  );
}

/** How the list stands as a whole, in words; redrawn when that changes and no more often. */
function useStanding(list: JobList): { total: number | null; failure: Error | null } {
  const [standing, setStanding] = useState({ total: list.total, failure: list.failure });
  useEffect(
    () =>
      list.version.subscribe(() =>
        setStanding((old) => (old.total === list.total && old.failure === list.failure ? old : { total: list.total, failure: list.failure })),
      ),
    [list],
  );
  return standing;
}

function Total({ list, filtered }: { list: JobList; filtered: boolean }) {
  const { total } = useStanding(list);
  return (
    <span class="muted" role="status">
      {total === null ? "" : `${jobsText(total)}${filtered ? " match" : ""}`}
    </span>
  );
}

interface Props {
  filter: Filter;
  list: JobList;
  onFilter: (filter: Filter) => void;
  input: { current: HTMLInputElement | null };
  grid: { current: GridControl | null };
}

/** The list of one filter, and what one does with it. */
function JobsOf({ filter, list, onFilter, input, grid }: Props) {
  const { route } = useLocation();
  const { total, failure } = useStanding(list);
  const left = useMemo(placeLeft, []);
  const [active, setActive] = useState(left.active);
  const [picked, setPicked] = useState<Selection>(kNothing);
  const [above, setAbove] = useState(0);
  const [bulk, setBulk] = useState<{ action: BulkAction; targets: Targets } | null>(null);
  // A range goes from here, and is added to what was picked when it began.
  const range = useRef({ from: left.active, base: kNothing, asked: 0 });
  const count = picked.all ? (total ?? 0) : picked.jobs.size;

  useEffect(() => {
    if (document.activeElement === document.body || document.activeElement?.id === "room") grid.current?.focus();
  }, []);
  const here = useRef({ at: "", active });
  here.current = { at: window.location.search, active };
  useEffect(
    () => () => sessionStorage.setItem(kPlaceKey, JSON.stringify({ ...here.current, scrollTop: grid.current?.scrollTop() ?? 0 })),
    [],
  );

  const last = () => Math.max(0, (list.total ?? 1) - 1);
  const goTo = (place: number) => {
    const to = Math.max(0, Math.min(last(), place));
    setActive(to);
    grid.current?.show(to);
    return to;
  };
  const begin = (from: number, base: Selection) => (range.current = { from, base, asked: range.current.asked + 1 });
  const move = (to: number) => begin(goTo(to), picked);
  const pickRange = (to: number) => {
    const { from, base } = range.current;
    const asked = ++range.current.asked;
    list.range(Math.min(from, to), Math.max(from, to)).then((jobs) => {
      if (asked === range.current.asked) setPicked(withJobs(base, jobs));
    }, sayFailure);
  };
  const pick = (place: number, toHere: boolean) => {
    setActive(place);
    if (toHere) return pickRange(place);
    const job = list.row(place);
    const next = job ? toggled(picked, job) : picked;
    begin(place, next);
    setPicked(next);
  };
  const extend = (by: number) => pickRange(goTo(active + by));
  const pickAll = () => setPicked((old) => (old.all ? kNothing : { all: true, jobs: new Map() }));

  const targets = (): Targets | null => {
    if (picked.all) return { allOf: filter };
    const known = renewed(picked, (id) => list.row(list.placeOf(id) ?? -1));
    if (known.jobs.size > 0) return { jobs: [...known.jobs.values()] };
    const job = list.row(active);
    return job ? { jobs: [job] } : null;
  };
  // One job is changed at once, for it is as easily changed back; several only when confirmed, and so is what is final.
  const act = (action: BulkAction) => {
    const of = targets();
    if (!of) return;
    const one = "jobs" in of && of.jobs.length === 1 ? of.jobs[0]! : null;
    if (!one || action.kind === "purge") return setBulk({ action, targets: of });
    if (!statesFor(action).includes(one.state)) return say(`${one.id} is ${one.state}; that goes for jobs that are ${statesFor(action).join(" or ")}.`);
    const done = action.kind === "priority" ? `has priority ${action.priority}` : kActionWords[action.kind].done;
    const set = (priority: number) => action.kind === "priority" && list.patch({ id: one.id, priority });
    if (action.kind === "priority") set(action.priority);
    doTo(one.id, action).then(
      () => say(`${one.id} ${done}.`),
      (failure: unknown) => {
        set(one.priority);
        sayFailure(failure);
      },
    );
  };
  const changePriority = (by: number) => {
    const of = targets();
    const one = of && "jobs" in of && of.jobs.length === 1 ? of.jobs[0]! : null;
    act({ kind: "priority", priority: clampPriority((one?.priority ?? 0) + by) });
  };
  const compare = () => {
    const jobs: JobSummary[] = [...picked.jobs.values()];
    if (jobs.length < 2 || jobs.length > kMostCompared) return say(`Select 2 to ${kMostCompared} jobs to compare their images.`);
    route(`/compare?images=${jobs.map((job) => `job:${job.id}`).join(",")}`);
  };
  const open = () => {
    const job = list.row(active);
    if (job) route(`/jobs/${job.id}`);
  };
  const key = (name: string, text: string, run: () => void): Key => ({ key: name, text, run });
  const keys = [
    key("j", "next job", () => move(active + 1)),
    key("ArrowDown", "next job", () => move(active + 1)),
    key("k", "previous job", () => move(active - 1)),
    key("ArrowUp", "previous job", () => move(active - 1)),
    key("PageDown", "a page down or up", () => move(active + grid.current!.pageRows())),
    key("PageUp", "a page down or up", () => move(active - grid.current!.pageRows())),
    key("Home", "newest, oldest", () => move(0)),
    key("End", "newest, oldest", () => move(last())),
    key("x", "select", () => pick(active, false)),
    key(" ", "select", () => pick(active, false)),
    key("Shift+ArrowDown", "select up to the next", () => extend(1)),
    key("Shift+ArrowUp", "select up to the next", () => extend(-1)),
    key("a", "select all that match", pickAll),
    key("Escape", "select none", () => setPicked(kNothing)),
    key("Enter", "open", open),
    key("/", "filter", () => input.current?.focus()),
    key("c", "cancel", () => act({ kind: "cancel" })),
    key("r", "retry", () => act({ kind: "retry" })),
    key("+", "higher or lower priority", () => changePriority(kPriorityStep)),
    key("-", "higher or lower priority", () => changePriority(-kPriorityStep)),
    key("v", "compare the images selected", compare),
  ];
  useKeys("Jobs", keys, [list, active, picked, filter]);

  const lost = connection.value === "lost";
  return (
    <>
      {(lost || failure) && (
        <p class="notice failed row" role="alert">
          {lost ? "The daemon does not answer. What is shown is as it was; it is asked again and again." : failure!.message}
          {!lost && <button onClick={() => void list.refresh()}>Ask again</button>}
        </p>
      )}
      <div class="jobs-actions row" role="toolbar" aria-label="What to do with the selected jobs">
        <span class="jobs-count">
          {count === 0 ? <span class="muted jobs-hint">Nothing selected: the marked job is meant. Select with x or Shift.</span> : <strong>{jobsText(count)} selected</strong>}
        </span>
        {!picked.all && (total ?? 0) > 0 && (
          <button class="quiet" onClick={pickAll}>
            Select all {total!.toLocaleString("en")}
          </button>
        )}
        {count > 0 && (
          <button class="quiet" onClick={() => setPicked(kNothing)}>
            Select none
          </button>
        )}
        <span class="jobs-buttons row">
          <button disabled={total === 0} onClick={compare} title="v">
            Compare images
          </button>
          <button disabled={!total} onClick={() => act({ kind: "retry" })} title="r">
            Retry
          </button>
          <button disabled={!total} onClick={() => setBulkPriority()} title="+ and −">
            Priority
          </button>
          <button disabled={!total} onClick={() => act({ kind: "cancel" })} title="c">
            Cancel
          </button>
          <button disabled={!total} class="danger" onClick={() => act({ kind: "purge" })}>
            Remove
          </button>
        </span>
      </div>
      <div class="jobs-list">
        {above > 0 && (
          <button
            class="primary jobs-above"
            onClick={() => {
              grid.current?.toTop();
              move(0);
            }}
          >
            ↑ {above === 1 ? "1 new job" : `${above} new jobs`}
          </button>
        )}
        <JobGrid
          list={list}
          selection={picked}
          active={active}
          onShift={(by, above) => {
            setActive((old) => Math.max(0, old + by)); // the marked job stays the same, whatever comes
            range.current.from += by;
            if (above) setAbove((old) => Math.max(0, old + by));
          }}
          onTop={() => setAbove(0)}
          onPoint={(place) => {
            setActive(place);
            begin(place, picked);
          }}
          onPick={pick}
          onPickAll={pickAll}
          control={grid}
          startAt={left.scrollTop}
        />
        {total === 0 && (
          <div class="empty jobs-none">
            {filterText(filter) ? (
              <>
                <p>No job matches.</p>
                <button onClick={() => onFilter(filterOfQuery({}))}>Show all jobs</button>
              </>
            ) : (
              <>
                <p>Nothing has been rendered yet.</p>
                <a class="button primary" href="/render">
                  Render an image
                </a>
              </>
            )}
          </div>
        )}
      </div>
      <DropRequest />
      {bulk && (
        <BulkDialog
          {...bulk}
          onClose={() => {
            setBulk(null);
            void list.refresh();
            // Unless one has gone elsewhere already.
            if (document.activeElement === document.body || document.activeElement?.closest("dialog")) grid.current?.focus();
          }}
        />
      )}
    </>
  );

  function setBulkPriority() {
    const of = targets();
    if (!of) return;
    const first = "jobs" in of ? of.jobs.find((job) => !isOver(job.state)) : undefined;
    setBulk({ action: { kind: "priority", priority: first?.priority ?? 0 }, targets: of });
  }
}
