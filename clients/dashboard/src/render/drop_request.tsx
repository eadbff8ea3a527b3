// An image of photond dropped on a room opens the form with the request that it was rendered by.

import { useLocation } from "preact-iso";

import { getJson, Problem } from "../api/client";
import type { JobRequest, Scene } from "../api/types";
import { useDrop } from "../scenes/dropping";
import { scenePath } from "../scenes/scene_path";
import { minimalRequest } from "../ui/job_request";
import { sayFailure } from "../ui/toasts";
import { keepDraft } from "./draft";
import { kHeaderBytes, requestIn } from "./exr_request";

/** Says so where the daemon lacks the request's scene. */
async function lookForScene(request: JobRequest, file: string): Promise<void> {
  try {
    await getJson<Scene>(scenePath(request.scene));
  } catch (failure) {
    const isMissing = failure instanceof Problem && failure.status === 404;
    sayFailure(isMissing ? new Error(`${file} was rendered of the scene ${request.scene}, which this daemon has not: upload it first, or choose another.`) : failure);
  }
}

export function DropRequest() {
  const { route } = useLocation();
  const hovering = useDrop(async (files) => {
    const [dropped] = files;
    if (!dropped) return;
    const { name } = dropped.file;
    if (files.length > 1) return sayFailure(new Error("One image at a time can be repeated."));
    try {
      const request = requestIn(new Uint8Array(await dropped.file.slice(0, kHeaderBytes).arrayBuffer()));
      const search = `?${new URLSearchParams({ exr: name, drop: Date.now().toString(36) }).toString()}`;
      keepDraft(search, minimalRequest(request, []));
      route(`/render${search}`);
      await lookForScene(request, name);
    } catch (failure) {
      sayFailure(new Error(`${name} cannot be repeated: ${(failure as Error).message}`));
    }
  });
  return hovering ? (
    <p class="notice drop-request" role="status">
      Drop an EXR of photond here to repeat the job that made it.
    </p>
  ) : null;
}
