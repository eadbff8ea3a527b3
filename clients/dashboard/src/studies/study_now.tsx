// What of a comparison is being rendered: its picture as it becomes, and how long that goes on.

import type { ComparisonReport } from "../api/types";
import { useLivePreview } from "../ui/live_preview";
import { PictureFrame } from "../ui/picture";
import { passesText, progressText } from "../ui/progress";
import type { LiveJob } from "./live_study";
import { referenceJobs, rowName } from "./series";

interface Rendered {
  id: string;
  name: string;
  live: LiveJob;
}

/** The jobs that run, the reference among them. */
export function renderedNow(report: ComparisonReport, jobs: ReadonlyMap<string, LiveJob>): Rendered[] {
  const names = new Map(
    report.jobs.flatMap((job) => job.runs.map((run, i) => [run.id, i === 0 ? rowName(job) : `${rowName(job)} once more`] as const)),
  );
  for (const [index, job] of referenceJobs(report).entries()) names.set(job, index === 0 ? "the reference" : "the reference's other film");
  return [...names].flatMap(([id, name]) => {
    const live = jobs.get(id);
    return live?.state === "running" ? [{ id, name, live }] : [];
  });
}

function NowRendered({ id, name, live, ratio }: Rendered & { ratio: number }) {
  const image = useLivePreview(`/v1/jobs/${id}/preview.png?max_size=320`, live.passes);
  return (
    <li class="study-now">
      <a href={`/jobs/${id}`} class="study-now-picture" tabIndex={-1} aria-hidden="true">
        <PictureFrame image={image} alt="" ratio={ratio} waiting={live.passes ? "" : "before the first pass"} />
      </a>
      <div>
        <p>
          Rendering <a href={`/jobs/${id}`}>{name}</a>
        </p>
        <progress max={1} value={live.progress} aria-label={`Progress of ${name}`} />
        <p class="small">{progressText(live)}</p>
        <p class="small muted">{passesText(live.passes, live.seconds)}</p>
      </div>
    </li>
  );
}

export function StudyNow({ report, jobs }: { report: ComparisonReport; jobs: ReadonlyMap<string, LiveJob> }) {
  const rendered = renderedNow(report, jobs);
  if (rendered.length === 0) return null;
  const { width, height } = report.request.image;
  return (
    <ul class="panel study-now-list" aria-label="What is being rendered">
      {rendered.map((one) => (
        <NowRendered key={one.id} {...one} ratio={width / height} />
      ))}
    </ul>
  );
}
