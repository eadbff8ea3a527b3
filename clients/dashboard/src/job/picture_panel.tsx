// What a job has rendered: its layers, live while it runs, and how far it is from its reference.

import type { Job } from "../api/types";
import { isOver } from "../api/types";
import { withQuery } from "../api/client";
import { alwaysLayers, layerNamed } from "../api/vocabulary";
import { useQuery } from "../app/url_state";
import { plainName, sizeText } from "../ui/format";
import { useLivePreview } from "../ui/live_preview";
import { Picture, PictureFrame } from "../ui/picture";

const isDrawn = (layer: string): boolean => layerNamed(layer)?.preview != null;
const hasExposure = (layer: string): boolean => layerNamed(layer)?.exposure ?? true;
const kLargest = 1280;
const kThumbnail = 160;

/** "image", and what the job is measured by where it has a reference. */
function viewsOf(job: Job): { name: string; title: string; text: string }[] {
  const views = [{ name: "image", title: "Image", text: "" }];
  if (job.links.flip) views.push({ name: "flip", title: "FLIP", text: "Differences a viewer would see when flipping between it and its reference; brighter is worse." });
  if (job.links.error_map) views.push({ name: "error", title: "Relative error", text: "How far each pixel is from its reference, relative to it and on a logarithmic scale; brighter is worse. Too bright and too dark look alike." });
  if (referenceJob(job)) views.push({ name: "reference", title: "Reference", text: referenceJobs(job).length > 1 ? `One of the two films it is measured against, ${referenceJob(job)}.` : "What it is measured against." });
  return views;
}

/** The jobs it is measured against: two films, or one; none where an image was uploaded. */
export function referenceJobs(job: Job): string[] {
  if (job.reference_jobs) return job.reference_jobs;
  if (job.reference_job) return [job.reference_job];
  const { reference } = job.request;
  return typeof reference === "string" && reference.startsWith("job:") ? [reference.slice(4)] : [];
}

const referenceJob = (job: Job): string | null => referenceJobs(job)[0] ?? null;

/** Films are changed by passes and by attempts; anything else leaves the pictures as they are. */
const versionOf = (job: Job): number => job.passes_done + (isOver(job.state) ? 0.5 : 0);

function Shown({ job, view, query }: { job: Job; view: string; query: Record<string, string> }) {
  const { layer = "beauty", exposure, curve } = query;
  const tone = { layer, ...(hasExposure(layer) ? { exposure, curve } : {}), max_size: kLargest };
  const self = `/v1/jobs/${job.id}`;
  const paths: Record<string, string> = {
    image: withQuery(`${self}/preview.png`, tone),
    flip: withQuery(`${self}/flip.png`, { layer }),
    error: withQuery(`${self}/error.png`, { layer }),
    reference: withQuery(`/v1/jobs/${referenceJob(job)}/preview.png`, tone),
  };
  const image = useLivePreview(paths[view]!, view === "reference" ? 0 : versionOf(job));
  const { width, height } = job.request.image;
  const alt = `${view === "image" ? "Rendered image" : view} of ${job.id}, ${plainName(layer)}`;
  return <PictureFrame image={image} alt={alt} ratio={Math.min(4, Math.max(0.5, width / height))} waiting={isOver(job.state) ? "" : "The first pass is not done yet."} />;
}

export function PicturePanel({ job }: { job: Job }) {
  const [query, setQuery] = useQuery();
  const views = viewsOf(job);
  const view = views.find(({ name }) => name === query.show) ?? views[0]!;
  const layers = [...alwaysLayers(), ...job.request.layers.filter(isDrawn)];
  const others = job.request.layers.filter((name) => !isDrawn(name));
  const layer = layers.includes(query.layer ?? "") ? query.layer! : "beauty";
  const exposure = Number(query.exposure ?? 0) || 0;
  const reference = referenceJob(job);
  const hasFilm = job.passes_done > 0;
  const closer = (of: string) =>
    withQuery("/compare", {
      images: [job.id, ...(reference ? [reference] : [])].map((id) => `job:${id}`).join(),
      reference: reference ? `job:${reference}` : null,
      layer: of === "beauty" ? null : of,
    });
  const flat = view.name === "flip" || view.name === "error" || !hasExposure(layer);
  if (!hasFilm && isOver(job.state))
    return (
      <section class="panel job-picture" aria-labelledby="job-picture-title">
        <h2 id="job-picture-title">Image</h2>
        <p class="empty">No pass was finished, so there is no image.</p>
      </section>
    );
  return (
    <section class="panel job-picture" aria-labelledby="job-picture-title">
      <div class="row job-picture-bar">
        <h2 id="job-picture-title">Image</h2>
        {views.length > 1 && (
          <div class="row" role="group" aria-label="What is shown">
            {views.map(({ name, title }) => (
              <button key={name} class="small" aria-pressed={name === view.name} onClick={() => setQuery({ show: name === "image" ? null : name })}>
                {title}
              </button>
            ))}
          </div>
        )}
        <a class="job-compare" href={closer(layer)}>
          Look closer{reference ? ", beside its reference" : ""}
        </a>
      </div>
      <Shown key={`${view.name} ${layer} ${exposure} ${query.curve}`} job={job} view={view.name} query={{ ...query, layer }} />
      {view.text && <p class="hint">{view.text}</p>}
      <div class="row job-tone">
        <label class="row">
          Exposure
          <input
            type="range"
            min={-8}
            max={8}
            step={0.5}
            value={exposure}
            disabled={flat}
            onChange={(event) => setQuery({ exposure: event.currentTarget.value === "0" ? null : event.currentTarget.value })}
          />
          <output class="small">
            {exposure > 0 ? "+" : ""}
            {exposure} stops
          </output>
        </label>
        <label class="row">
          Tone curve
          <select value={query.curve ?? "srgb"} disabled={flat} onChange={(event) => setQuery({ curve: event.currentTarget.value === "srgb" ? null : event.currentTarget.value })}>
            <option value="srgb">sRGB</option>
            <option value="filmic">filmic</option>
          </select>
        </label>
        <span class="muted small job-size">{sizeText(job.request.image)} pixels</span>
      </div>
      {hasFilm && (
        <div class="job-layers" role="group" aria-label="Layers">
          {layers.map((name) => (
            <button key={name} class="job-layer" aria-pressed={name === layer} onClick={() => setQuery({ layer: name === "beauty" ? null : name })}>
              <Picture
                path={withQuery(`/v1/jobs/${job.id}/preview.png`, { layer: name, max_size: kThumbnail })}
                version={isOver(job.state) ? "over" : "so far"}
                alt=""
                ratio={job.request.image.width / job.request.image.height}
              />
              {plainName(name)}
            </button>
          ))}
        </div>
      )}
      {hasFilm && others.length > 0 && (
        <p class="hint">
          Layers of numbers, to be looked at closer:{" "}
          {others.map((name, index) => (
            <span key={name}>
              {index > 0 && ", "}
              <a href={`/compare?images=job:${job.id}&layer=${name}`}>{plainName(name)}</a>
            </span>
          ))}
        </p>
      )}
    </section>
  );
}
