// Exposure by the image itself, as the daemon has it for pictures of scenes (renderer/film/tone_curve.h): [Reinhard et al.
// 2002] Photographic Tone Reproduction for Digital Images, Eq. 1.

import { kMiddleGrey, luminanceOf } from "./paint";
import { reader, type PixelImage } from "./pixels";

/** What counts as lit. */
const kLeastLuminance = 1e-6;

const found = new WeakMap<PixelImage, number | null>();

/** Stops, to a hundredth, that bring the log-average luminance of the lit pixels to middle grey; null where none is lit. */
export function autoExposureStops(image: PixelImage): number | null {
  let stops = found.get(image);
  if (stops === undefined) found.set(image, (stops = judged(image)));
  return stops;
}

function judged({ data, channels }: PixelImage): number | null {
  const read = reader(data);
  let sum = 0;
  let count = 0;
  for (let first = 0; first < data.length; first += channels) {
    const luminance = channels === 1 ? read(first) : luminanceOf([read(first), read(first + 1), read(first + 2)]);
    if (!(luminance > kLeastLuminance) || !Number.isFinite(luminance)) continue;
    sum += Math.log2(luminance);
    ++count;
  }
  return count ? Math.round(100 * (Math.log2(kMiddleGrey) - sum / count)) / 100 : null;
}
