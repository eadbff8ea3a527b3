// Which images: of the newest jobs, by id, or files.

import { useState } from "preact/hooks";

import type { JobSummary, JobSummaryPage } from "../api/types";
import { Dialog } from "../ui/dialog";
import { plainName, secondsText, sizeText, timeText } from "../ui/format";
import { Picture } from "../ui/picture";
import { useRemote } from "../ui/remote";
import { sceneName } from "../ui/scene_names";
import { kMaxImages, sourceOfText } from "./look";
import { passesText } from "./sources";
import { kAccepted } from "./uploads";

const kJobs = 60;

export const jobText = (job: JobSummary): string => `${job.id} ${plainName(job.method)}`;
export const jobFacts = (job: JobSummary): string => `${job.state === "succeeded" ? "" : `${job.state}, `}${passesText(job.passes_done)}, ${secondsText(job.seconds)}`;

/** The newest jobs that may have pixels. */
export const useNewestJobs = (scene = "") =>
  useRemote<JobSummaryPage>(`/v1/jobs?view=summary&state=succeeded,running,cancelled&limit=${kJobs}${scene ? `&scene=${encodeURIComponent(scene)}` : ""}`);

interface PickerProps {
  images: string[];
  size: { width: number; height: number } | null;
  onAdd: (sources: string[]) => void;
  onFiles: (files: File[]) => void;
  onClose: () => void;
}

export function Picker({ images, size, onAdd, onFiles, onClose }: PickerProps) {
  const jobs = useNewestJobs();
  const [wanted, setWanted] = useState("");
  const [typed, setTyped] = useState("");
  const [chosen, setChosen] = useState<string[]>([]);
  const room = kMaxImages - images.length - chosen.length;
  const words = wanted.toLowerCase().split(/\s+/).filter(Boolean);
  const shown = (jobs.data?.items ?? []).filter((job) => {
    const text = `${job.id} ${job.scene} ${sceneName(job.scene)} ${plainName(job.method)} ${sizeText(job)} ${Object.values(job.labels).join(" ")}`.toLowerCase();
    return words.every((word) => text.includes(word));
  });
  const typedSource = sourceOfText(typed);
  const toggle = (source: string) => setChosen(chosen.includes(source) ? chosen.filter((one) => one !== source) : [...chosen, source]);
  const add = (sources: string[]) => {
    onAdd(sources);
    onClose();
  };
  return (
    <Dialog title="Add images" onClose={onClose}>
      <div class="stack compare-picker">
        <div class="row">
          <form
            class="row"
            onSubmit={(event) => {
              event.preventDefault();
              if (typedSource) add([...chosen, typedSource]);
            }}
          >
            <label class="compare-field">
              <span>By id</span>
              <input value={typed} onInput={(event) => setTyped(event.currentTarget.value)} placeholder="J17 or image:…" size={14} aria-invalid={typed !== "" && !typedSource} />
            </label>
            <button disabled={!typedSource || room < 1}>Add</button>
          </form>
          <FileButton
            onFiles={(files) => {
              onFiles(files);
              onClose();
            }}
          />
        </div>
        <label class="compare-field">
          <span>Of the newest jobs</span>
          <input type="search" value={wanted} onInput={(event) => setWanted(event.currentTarget.value)} placeholder="scene, method, size …" />
        </label>
        {jobs.failure && <p class="notice failed">{jobs.failure.message}</p>}
        {jobs.data && shown.length === 0 && <p class="empty">{jobs.data.items.length ? "No job is like that." : "There are no jobs with pixels yet."}</p>}
        <ul class="compare-jobs">
          {shown.map((job) => {
            const source = `job:${job.id}`;
            const here = images.includes(source);
            const picked = chosen.includes(source);
            const otherSize = size && (job.width !== size.width || job.height !== size.height);
            return (
              <li key={job.id}>
                <label class={picked ? "picked" : undefined}>
                  <Picture path={`/v1/jobs/${job.id}/preview.png?max_size=160`} alt="" ratio={4 / 3} waiting="…" />
                  <span class="compare-job-name">
                    <input type="checkbox" checked={here || picked} disabled={here || (!picked && room < 1)} onChange={() => toggle(source)} />
                    <span>
                      <b>{jobText(job)}</b>
                      <span class="small muted">
                        {sceneName(job.scene)}, {sizeText(job)}
                        {otherSize && " (another size)"}
                      </span>
                      <span class="small muted">
                        {jobFacts(job)}, {timeText(job.finished ?? job.created)}
                      </span>
                    </span>
                  </span>
                </label>
              </li>
            );
          })}
        </ul>
        <div class="row compare-picker-end">
          <span class="muted">{room < 1 ? `${kMaxImages} images at most` : chosen.length ? `${chosen.length} chosen` : ""}</span>
          <button class="primary" disabled={chosen.length === 0} onClick={() => add(chosen)}>
            Add {chosen.length || ""}
          </button>
        </div>
      </div>
    </Dialog>
  );
}

export function FileButton({ onFiles }: { onFiles: (files: File[]) => void }) {
  return (
    <label class="button compare-file">
      Files …
      <input
        type="file"
        class="visually-hidden"
        accept={kAccepted}
        multiple
        onChange={(event) => {
          onFiles([...(event.currentTarget.files ?? [])]);
          event.currentTarget.value = "";
        }}
      />
    </label>
  );
}
