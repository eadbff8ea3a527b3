// Nothing chosen yet: jobs that are worth a look beside each other.

import { sizeText } from "../ui/format";
import { Picture } from "../ui/picture";
import { sceneName } from "../ui/scene_names";
import { jobGroups } from "./job_groups";
import { FileButton, jobFacts, jobText, useNewestJobs } from "./picker";

const kInGroup = 4;

export function Start({ onPick, onFiles }: { onPick: () => void; onFiles: (files: File[]) => void }) {
  const jobs = useNewestJobs();
  const groups = jobGroups(jobs.data?.items ?? [], kInGroup);
  return (
    <div class="stack">
      <section class="panel compare-drop">
        <p>
          Two to nine images: rendered here, or OpenEXR and Radiance files<span class="by-mouse">, which may be dropped anywhere on this page</span>. They are compared in linear light, with error maps on one
          scale.
        </p>
        <div class="row">
          <button class="primary" onClick={onPick}>
            Choose images …
          </button>
          <FileButton onFiles={onFiles} />
        </div>
      </section>
      {jobs.failure && <p class="notice failed">{jobs.failure.message}</p>}
      {jobs.loading && !jobs.data && <p class="empty">Jobs are looked up …</p>}
      {jobs.data && groups.length === 0 && (
        <p class="empty">
          There are no two finished jobs of one scene and size yet. <a href="/render">Render an image</a> twice, by two methods, or <a href="/studies/new">compare methods</a>.
        </p>
      )}
      {groups.length > 0 && (
        <section class="stack" aria-labelledby="compare-start">
          <h2 id="compare-start">Of the same scene and size</h2>
          <div class="panels">
            {groups.map((group) => (
              <article key={group.key} class="panel compare-group">
                <header class="row">
                  <h3>{sceneName(group.scene)}</h3>
                  <span class="muted small">{sizeText(group)}</span>
                  <a class="button" href={`/compare?images=${group.jobs.map((job) => `job:${job.id}`).join(",")}`} aria-label={`Compare these ${group.jobs.length} images of ${sceneName(group.scene)}, ${sizeText(group)}`}>
                    Compare these {group.jobs.length}
                  </a>
                </header>
                <ul class="compare-jobs">
                  {group.jobs.map((job) => (
                    <li key={job.id}>
                      <Picture path={`/v1/jobs/${job.id}/preview.png?max_size=160`} alt="" ratio={4 / 3} waiting="…" />
                      <b class="small">{jobText(job)}</b>
                      <span class="small muted">{jobFacts(job)}</span>
                    </li>
                  ))}
                </ul>
              </article>
            ))}
          </div>
        </section>
      )}
    </div>
  );
}
