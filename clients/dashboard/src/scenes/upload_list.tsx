import { bytesText, percentText } from "../ui/format";
import { dismiss, type Upload, uploads } from "./uploads";
import { scenePage } from "./scene_path";

function Row({ upload }: { upload: Upload }) {
  const { id, name, bytes, sent, scene, failure } = upload;
  if (failure !== undefined)
    return (
      <li class="notice failed scenes-upload">
        <div role="alert">
          {name && <strong>{name}: </strong>}
          {failure}
          {upload.faults && upload.faults.length > 0 && (
            <ul>
              {upload.faults.map((fault) => (
                <li key={`${fault.pointer} ${fault.detail}`}>
                  {fault.pointer && <code>{fault.pointer}</code>} {fault.detail}
                </li>
              ))}
            </ul>
          )}
        </div>
        <button class="quiet" onClick={() => dismiss(id)} aria-label={`Dismiss ${name}`}>
          ✕
        </button>
      </li>
    );
  if (scene)
    return (
      <li class="notice good scenes-upload">
        <div role="status">
          <strong>{scene.name}</strong> {upload.known ? "was here already, byte for byte." : "is here."} <a href={scenePage(scene)}>Open it</a>
          {scene.warnings.length > 0 && ` – ${scene.warnings.length === 1 ? "1 warning" : `${scene.warnings.length} warnings`}`}
        </div>
        <button class="quiet" onClick={() => dismiss(id)} aria-label={`Dismiss ${scene.name}`}>
          ✕
        </button>
      </li>
    );
  return (
    <li class="panel scenes-upload">
      <div>
        <strong>{name}</strong>{" "}
        <span class="muted">{sent < 1 ? `${percentText(sent)} of ${bytesText(bytes)} sent` : "sent; the daemon reads it …"}</span>
        <progress max={1} {...(sent < 1 ? { value: sent } : {})} aria-label={`Upload of ${name}`} />
      </div>
      <button class="quiet" onClick={() => upload.stop?.()}>
        Stop
      </button>
    </li>
  );
}

export function UploadList() {
  if (uploads.value.length === 0) return null;
  return (
    <ul class="scenes-uploads" aria-label="Uploads">
      {uploads.value.map((upload) => (
        <Row key={upload.id} upload={upload} />
      ))}
    </ul>
  );
}
