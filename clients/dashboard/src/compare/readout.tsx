// The values of a pixel in every image, and its errors.

import { ByPointer } from "../ui/by_pointer";
import { channelNames, layerKind, luminanceOf, relativeError, signedError } from "./paint";
import { pixelAt } from "./pixels";
import type { Desk } from "./desk";
import { NumberBox } from "./toolbar";
import { clamp } from "./view";

/** Four digits; what is not finite in words. */
export function valueText(value: number | null): string {
  if (value === null) return "–";
  if (Number.isNaN(value)) return "NaN";
  if (!Number.isFinite(value)) return value > 0 ? "∞" : "−∞";
  const size = Math.abs(value);
  const text = size !== 0 && (size < 1e-3 || size >= 1e5) ? value.toExponential(3).replace("e+", "e") : String(Number(value.toPrecision(4)));
  return text.replaceAll("-", "−");
}

export function Readout({ desk }: { desk: Desk }) {
  const images = desk.part("images").value;
  const pixel = desk.pixel.value;
  const layer = desk.part("layer").value;
  const error = desk.part("error").value;
  const size = desk.size.value;
  const ground = desk.ground.value;
  const light = layerKind(layer, ground.channels) === "light" && ground.channels === 3;
  const names = channelNames(layerKind(layer, ground.channels), ground.channels);
  const paint = desk.paints.value.error;
  const reference = desk.reference.value;
  const referenceImage = desk.pixels(reference);
  const against = pixel && referenceImage && pixelAt(referenceImage, pixel.x, pixel.y);
  const kind = error === "signed" || error.startsWith("flip") ? error : "relative";
  const errorName = kind === "signed" ? "Signed" : kind === "relative" ? "Relative" : "FLIP";

  function errorAt(index: number, values: number[] | null): number | null {
    if (!pixel || !values || !against || index === reference || desk.whyNoError(index)) return null;
    if (kind === "signed") return signedError(values, against, paint.channel);
    if (kind === "relative") return relativeError(values, against, ground.channels === 1 ? "r" : desk.part("channel").value, paint.floor);
    const flip = desk.flipEntry(index)?.image;
    return flip ? (pixelAt(flip, pixel.x, pixel.y)?.[0] ?? null) : null;
  }

  const rows = images.map((name, index) => {
    const image = desk.pixels(index);
    const values = pixel && image ? pixelAt(image, pixel.x, pixel.y) : null;
    return { name, index, values, error: errorAt(index, values) };
  });
  const spoken = desk.cursorOn.value && pixel ? `Pixel ${pixel.x}, ${pixel.y}: ${rows[desk.part("shown").value]?.values?.map(valueText).join(", ") ?? "outside"}` : "";
  return (
    <section class="panel" aria-labelledby="compare-pixel">
      <h2 id="compare-pixel">Pixel</h2>
      <div class="row compare-at">
        <label class="small">
          <input type="checkbox" checked={desk.cursorOn.value} onChange={() => toggleCursor(desk)} /> arrow keys move it
        </label>
        <span class="compare-field">
          <span>x</span>
          <NumberBox label="Pixel's column" value={pixel?.x ?? 0} step={1} min={0} max={size.width - 1} onValue={(x) => desk.change({ pixel: { x: Math.floor(x), y: pixel?.y ?? 0 } })} />
          <span>y</span>
          <NumberBox label="Pixel's row" value={pixel?.y ?? 0} step={1} min={0} max={size.height - 1} onValue={(y) => desk.change({ pixel: { x: pixel?.x ?? 0, y: Math.floor(y) } })} />
        </span>
      </div>
      <div class="scroll-x" tabIndex={0} role="region" aria-label="Values of the pixel">
        <table class="compare-values">
          <thead>
            <tr>
              <th scope="col">
                <abbr title="The image's number">#</abbr>
              </th>
              {names.map((name) => (
                <th key={name} scope="col" class="number">
                  {name}
                </th>
              ))}
              {light && (
                <th scope="col" class="number">
                  <abbr title="Luminance">Lum.</abbr>
                </th>
              )}
              {images.length > 1 && (
                <th scope="col" class="number">
                  {errorName}
                </th>
              )}
            </tr>
          </thead>
          <tbody>
            {rows.map(({ name, index, values, error: wrong }) => (
              <tr key={name} class={index === desk.part("shown").value ? "shown" : undefined}>
                <th scope="row">
                  {index + 1}
                  {index === reference && images.length > 1 ? " ref." : ""}
                </th>
                {names.map((channel, k) => (
                  <td key={channel} class={`number mono${values && Number.isNaN(values[k]) ? " nan" : ""}`}>
                    {valueText(values?.[k] ?? null)}
                  </td>
                ))}
                {light && <td class="number mono">{valueText(values ? luminanceOf(values) : null)}</td>}
                {images.length > 1 && <td class="number mono">{valueText(wrong)}</td>}
              </tr>
            ))}
          </tbody>
        </table>
      </div>
      {!pixel && <p class="hint compare-hint"><ByPointer mouse="Point at a picture; a click keeps the pixel. Or press p, then arrow keys." finger="Touch a picture: the pixel that is touched is read." /></p>}
      <p class="visually-hidden" aria-live="polite">
        {spoken}
      </p>
    </section>
  );
}

export function toggleCursor(desk: Desk): void {
  const on = !desk.cursorOn.peek();
  desk.cursorOn.value = on;
  if (on && !desk.look.peek().pixel) {
    const { centre } = desk.view.peek();
    const size = desk.size.peek();
    desk.change({ pixel: { x: clamp(Math.floor(centre.x), 0, size.width - 1), y: clamp(Math.floor(centre.y), 0, size.height - 1) } });
  }
}
