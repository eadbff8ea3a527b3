// Crops of all images beside each other at a whole zoom, as papers show them.

import { useEffect, useRef } from "preact/hooks";

import type { Desk } from "./desk";
import { cropAbout, cropWithin, kMaxCrops, kMaxCropSide, type Crop } from "./crops";
import { kMaxCropZoom } from "./look";
import { enlarged } from "./present";
import { NumberBox } from "./toolbar";

export const kCropLetters = "ABCDEF";

/** A crop of an image as it is shown; null where there is none. */
export function cropPicture(desk: Desk, index: number, crop: Crop, zoom: number): HTMLCanvasElement | null {
  const picture = desk.shown.peek()[index]?.picture;
  const developer = desk.developer.peek();
  if (!picture || !developer) return null;
  const { image } = picture;
  // What lies outside of a smaller image is not there.
  if (crop.x + crop.width > image.width || crop.y + crop.height > image.height) return null;
  return enlarged(developer, picture, crop, zoom);
}

function CropPicture({ desk, index, crop }: { desk: Desk; index: number; crop: Crop }) {
  const canvas = useRef<HTMLCanvasElement>(null);
  const zoom = desk.part("cropZoom").value;
  const shown = desk.shown.value[index];
  const developer = desk.developer.value;
  const density = desk.density.value;
  useEffect(() => {
    const picture = developer && cropPicture(desk, index, crop, zoom);
    const context = canvas.current!.getContext("2d")!;
    canvas.current!.width = crop.width * zoom;
    canvas.current!.height = crop.height * zoom;
    if (picture) context.drawImage(picture, 0, 0);
  }, [developer, shown?.picture, crop.x, crop.y, crop.width, crop.height, zoom]);
  const title = desk.sources.value.get(desk.part("images").value[index]!)?.title ?? "";
  return (
    <figure class="compare-crop">
      <canvas
        ref={canvas}
        role="img"
        aria-label={`Crop of image ${index + 1}, ${title}`}
        style={{ width: `${(crop.width * zoom) / density}px`, height: `${(crop.height * zoom) / density}px` }}
      />
      <figcaption style={{ maxWidth: `${Math.max(96, (crop.width * zoom) / density)}px` }}>
        <b>{index + 1}</b> {title}
      </figcaption>
    </figure>
  );
}

export function addCrop(desk: Desk): void {
  const look = desk.look.peek();
  if (look.crops.length >= kMaxCrops) return;
  const about = look.pixel ? { x: look.pixel.x + 0.5, y: look.pixel.y + 0.5 } : desk.view.peek().centre;
  desk.change({ crops: [...look.crops, cropAbout(about, desk.size.peek())] });
}

export function CropStrip({ desk, onSave }: { desk: Desk; onSave: () => void }) {
  const crops = desk.part("crops").value;
  const images = desk.part("images").value;
  const full = crops.length >= kMaxCrops;
  const replace = (at: number, crop: Crop | null) =>
    desk.change({ crops: crops.flatMap((other, i) => (i === at ? (crop ? [cropWithin(crop, desk.size.peek())] : []) : [other])) });
  return (
    <section class="panel" aria-labelledby="compare-crops">
      <div class="row compare-heading">
        <h2 id="compare-crops">Crops</h2>
        <button aria-pressed={desk.cropping.value} disabled={full} onClick={() => (desk.cropping.value = !desk.cropping.value)} title="Then drag over a picture (d); or drag with Shift held">
          Draw one
        </button>
        <button disabled={full} onClick={() => addCrop(desk)} title="About the pixel that is read, or the middle (k)">
          Put one here
        </button>
        {crops.length > 0 && (
          <>
            <span class="compare-field">
              <span>Zoom</span>
              <NumberBox label="Zoom of the crops" value={desk.part("cropZoom").value} step={1} min={1} max={kMaxCropZoom} onValue={(zoom) => desk.change({ cropZoom: Math.round(zoom) })} />
            </span>
            <button onClick={onSave}>Save as PNG</button>
          </>
        )}
      </div>
      {crops.length === 0 && (
        <p class="hint">
          Parts of the images, enlarged side by side: “Draw one”, then drag over a picture<span class="by-mouse"> (or drag with Shift held)</span>. “Put one here” puts one about the pixel that is read, or the
          middle of the view.
        </p>
      )}
      {crops.map((crop, at) => (
        <div key={at} class="compare-strip">
          <div class="row">
            <h3>{kCropLetters[at]}</h3>
            {(["x", "y", "width", "height"] as const).map((side) => (
              <span key={side} class="compare-field">
                <span>{side}</span>
                <NumberBox
                  label={`Crop ${kCropLetters[at]}: ${side}`}
                  value={crop[side]}
                  step={1}
                  min={side === "x" || side === "y" ? 0 : 1}
                  max={side === "x" || side === "y" ? undefined : kMaxCropSide}
                  onValue={(value) => replace(at, { ...crop, [side]: value })}
                />
              </span>
            ))}
            <button class="quiet" aria-label={`Remove crop ${kCropLetters[at]}`} onClick={() => replace(at, null)}>
              ✕
            </button>
          </div>
          <div class="compare-crops scroll-x" tabIndex={0} role="region" aria-label={`Crop ${kCropLetters[at]} of all images`}>
            {images.map((name, index) => (
              <CropPicture key={name} desk={desk} index={index} crop={crop} />
            ))}
          </div>
        </div>
      ))}
    </section>
  );
}
