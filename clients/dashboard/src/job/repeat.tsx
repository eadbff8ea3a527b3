// The job as lines that repeat it, and what it left to be fetched.

import { useState } from "preact/hooks";

import { ask, download, saveBlob } from "../api/client";
import { token } from "../api/token";
import type { Job, Method } from "../api/types";
import { curlText, minimalRequest, pythonText } from "../ui/job_request";
import { say, sayFailure } from "../ui/toasts";

const kTabs = ["curl", "Python", "JSON"] as const;

export function Repeat({ job, methods }: { job: Job; methods: Method[] }) {
  const [tab, setTab] = useState<(typeof kTabs)[number]>("curl");
  const request = minimalRequest(job.request, methods);
  const texts = {
    curl: () => curlText(request, window.location.origin, token() !== null),
    Python: () => pythonText(request, window.location.origin),
    JSON: () => JSON.stringify(request, null, 2),
  };
  const text = texts[tab]();
  const copy = () =>
    navigator.clipboard.writeText(text).then(
      () => say(`${tab} copied.`),
      () => sayFailure(new Error("The browser does not let the page copy; mark the text and copy it by hand.")),
    );
  return (
    <>
      <div class="row job-repeat-bar">
        <div class="row" role="group" aria-label="As what">
          {kTabs.map((name) => (
            <button key={name} class="small" aria-pressed={name === tab} onClick={() => setTab(name)}>
              {name}
            </button>
          ))}
        </div>
        <button class="small" onClick={() => void copy()}>
          Copy
        </button>
      </div>
      <pre class="job-code" tabIndex={0} aria-label={`${tab} to repeat the job`}>
        {text}
      </pre>
    </>
  );
}

interface File {
  link: string;
  title: string;
  name: string;
  query?: string;
  hint?: string;
}

const kFiles: File[] = [
  { link: "image", title: "EXR, float", name: "exr", query: "?precision=float", hint: "all layers" },
  { link: "image", title: "EXR, half", name: "half.exr", query: "?precision=half", hint: "all layers, half the size" },
  { link: "preview", title: "PNG", name: "png", hint: "as shown" },
  { link: "statistics", title: "Statistics", name: "statistics.json" },
  { link: "curve", title: "Curve", name: "curve.csv" },
  { link: "difference", title: "Difference", name: "difference.exr", hint: "image less reference" },
  { link: "flip", title: "FLIP map", name: "flip.png" },
  { link: "error_map", title: "Error map", name: "error.png" },
  { link: "film", title: "Film", name: "film", hint: "to merge or extend elsewhere" },
  { link: "log", title: "Log", name: "log.txt" },
];
const kNoFiles = ["self", "events"];

export function Files({ job }: { job: Job }) {
  const known = new Set([...kFiles.map(({ link }) => link), ...kNoFiles]);
  const more = Object.keys(job.links)
    .filter((link) => !known.has(link))
    .map((link): File => ({ link, title: link.replaceAll("_", " "), name: job.links[link]?.split("/").at(-1) ?? link }));
  const there = [...kFiles, ...more].filter(({ link }) => job.links[link] && (job.passes_done > 0 || link === "log" || link === "statistics"));
  // The picture as it is shown: by the layer and the exposure of the address.
  const queryOf = (file: File) => {
    if (file.link !== "preview") return file.query ?? "";
    const shown = new URLSearchParams(window.location.search);
    const kept = new URLSearchParams([...shown].filter(([name]) => ["layer", "exposure", "curve"].includes(name)));
    return kept.size > 0 ? `?${kept}` : "";
  };
  const save = async (file: File) => {
    const path = job.links[file.link]! + queryOf(file);
    const name = `${job.id}.${file.name}`;
    try {
      if (file.link !== "statistics") return await download(path, name);
      const answer = await ask(path);
      if (answer.status === 202) return say("The statistics are there when the job is over.");
      saveBlob(await answer.blob(), name);
    } catch (failure) {
      sayFailure(failure);
    }
  };
  return (
    <ul class="job-files">
      {there.map((file) => (
        <li key={file.title}>
          <button class="small" onClick={() => void save(file)}>
            <span aria-hidden="true">↓</span> {file.title}
          </button>
          {file.hint && <span class="hint">{file.hint}</span>}
        </li>
      ))}
    </ul>
  );
}
