// One row of the list of jobs. Rows are drawn anew only when what they show has changed: while one scrolls there is time
// for little else.

import { Component } from "preact";

import type { JobSummary } from "../api/types";
import { shortError } from "../ui/error_interval";
import { kNone, percentText, plainName, secondsText, timeText } from "../ui/format";
import { sceneName } from "../ui/scene_names";

export interface Column {
  name: string;
  title: string;
  number?: boolean;
}

/** As they stand from left to right; job_grid.css has the widths. */
export const kColumns: Column[] = [
  { name: "pick", title: "" },
  { name: "job", title: "Job" },
  { name: "state", title: "State" },
  { name: "scene", title: "Scene" },
  { name: "method", title: "Method" },
  { name: "device", title: "Device" },
  { name: "size", title: "Size", number: true },
  { name: "passes", title: "Passes", number: true },
  { name: "time", title: "Time", number: true },
  { name: "error", title: "Error" },
  { name: "labels", title: "Labels" },
  { name: "priority", title: "Priority", number: true },
  { name: "created", title: "Created", number: true },
];

interface Props {
  job: JobSummary | undefined;
  place: number;
  top: number;
  height: number;
  selected: boolean;
  active: boolean;
  onPick: (place: number, range: boolean) => void;
  onPoint: (place: number) => void;
}

function State({ job }: { job: JobSummary }) {
  if (job.state !== "running") return <span class={`state ${job.state}`}>{job.state}</span>;
  return (
    <span class="jobs-running">
      <span class="state running">running</span>
      <progress value={job.progress} max={1} aria-label={`${job.id} ${percentText(job.progress)}`} />
      <span class="small" aria-hidden="true">
        {percentText(job.progress)}
      </span>
    </span>
  );
}

const labelsOf = (labels: Record<string, string>): string =>
  Object.entries(labels)
    .map(([key, value]) => `${key}=${value}`)
    .join(" ");

function Cells({ job }: { job: JobSummary }) {
  const error = shortError(job.error_now?.value, job.error_now?.interval);
  const labels = labelsOf(job.labels);
  const failed = job.state === "failed" && job.failure;
  const cells: Record<string, preact.ComponentChildren> = {
    job: (
      <>
        <a href={`/jobs/${job.id}`} tabIndex={-1}>
          {job.id}
        </a>
        {job.role !== "render" && <span class="jobs-role">{job.role}</span>}
      </>
    ),
    state: <State job={job} />,
    scene: <span title={job.scene}>{sceneName(job.scene)}</span>,
    method: plainName(job.method),
    device: job.device,
    size: `${job.width}×${job.height}`,
    passes: job.passes_done ? job.passes_done.toLocaleString("en") : kNone,
    time: job.seconds ? secondsText(job.seconds) : kNone,
    error: failed ? (
      <span class="fault" title={job.failure!}>
        {job.failure}
      </span>
    ) : error !== kNone ? (
      <>
        {error} <span class="muted">{plainName(job.error_now!.metric)}</span>
      </>
    ) : (
      kNone
    ),
    labels: <span title={labels}>{labels}</span>,
    priority: job.priority === 0 ? "0" : job.priority > 0 ? `+${job.priority}` : `−${-job.priority}`,
    created: <time dateTime={job.created}>{timeText(job.created)}</time>,
  };
  return (
    <>
      {kColumns.slice(1).map(({ name, number }, index) => (
        <span key={name} role="gridcell" aria-colindex={index + 2} class={`jobs-cell jobs-${name}${number ? " number" : ""}`}>
          {cells[name]}
        </span>
      ))}
    </>
  );
}

export class JobRow extends Component<Props> {
  override shouldComponentUpdate(next: Props): boolean {
    const now = this.props;
    return (
      next.job !== now.job || next.place !== now.place || next.top !== now.top || next.selected !== now.selected ||
      next.active !== now.active || next.height !== now.height
    );
  }

  override render({ job, place, top, selected, active, onPick, onPoint }: Props) {
    return (
      <div
        role="row"
        id={`jobs-row-${place}`}
        class={`jobs-row${selected ? " selected" : ""}${active ? " active" : ""}${job ? "" : " waits"}`}
        aria-rowindex={place + 2}
        aria-selected={selected}
        style={{ transform: `translateY(${top}px)` }}
        onClick={(event) => {
          // A link and a box do what they do; elsewhere a click points at the row, with Shift it picks up to it.
          if (event.target instanceof Element && event.target.closest("a, label")) return;
          if (event.shiftKey) onPick(place, true);
          else onPoint(place);
        }}
      >
        <span role="gridcell" aria-colindex={1} class="jobs-cell jobs-pick">
          <label class="jobs-box">
            <input
              type="checkbox"
              tabIndex={-1}
              checked={selected}
              disabled={!job}
              aria-label={job ? `Select ${job.id}` : "Loading"}
              onClick={(event) => {
                const box = event.currentTarget;
                onPick(place, event.shiftKey);
                // The box has turned by itself, which a range that held the row already does not undo.
                setTimeout(() => (box.checked = this.props.selected));
              }}
            />
          </label>
        </span>
        {job ? <Cells job={job} /> : <span role="gridcell" aria-colindex={2} aria-label="Loading" class="jobs-cell jobs-wait" />}
      </div>
    );
  }
}
