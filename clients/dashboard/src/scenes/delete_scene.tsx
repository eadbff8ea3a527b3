import { useState } from "preact/hooks";

import { Problem, sendJson } from "../api/client";
import type { Scene } from "../api/types";
import { Dialog } from "../ui/dialog";
import { scenePath } from "./scene_path";

/** Asks before a scene is deleted, and says what keeps it where it cannot be. */
export function DeleteScene({ scene, onClose, onDeleted }: { scene: Scene; onClose: () => void; onDeleted: () => void }) {
  const [failure, setFailure] = useState<Error | null>(null);
  const [deleting, setDeleting] = useState(false);
  const remove = async () => {
    setDeleting(true);
    try {
      await sendJson<Scene>("DELETE", scenePath(scene));
      onDeleted();
    } catch (reason) {
      setFailure(reason as Error);
      setDeleting(false);
    }
  };
  const used = failure instanceof Problem && failure.status === 409;
  return (
    <Dialog title={`Delete ${scene.name}?`} onClose={onClose}>
      <p>Its files go for good. Jobs that have rendered it keep their images, but cannot be retried or extended.</p>
      {failure && (
        <p class="notice failed" role="alert">
          {failure.message}. {used && <a href={`/jobs?scene=${encodeURIComponent(scene.id)}&state=queued,running`}>Show those jobs</a>}
        </p>
      )}
      <div class="row">
        <button class="danger" disabled={deleting} onClick={() => void remove()}>
          {deleting ? "Deleting …" : "Delete"}
        </button>
        <button onClick={onClose}>Keep it</button>
      </div>
    </Dialog>
  );
}
