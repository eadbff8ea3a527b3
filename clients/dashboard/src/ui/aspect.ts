// Sizes of images by their shape, width over height.

/** As many pixels as a first render has: 512 by 512. */
export const kFirstPixels = 512 * 512;

/** Numbers of pixels that sizes are offered for, from a sketch to a large screen. */
export const kPixelChoices = [256 ** 2, kFirstPixels, 1280 * 720, 1920 * 1080];

/** Pictures of a shape beyond these would be lines. */
export const boundedAspect = (aspect: number): number => Math.min(8, Math.max(1 / 8, aspect));

const kStep = 8; // sides are multiples of it

/** About as many pixels, of that shape to within a percent or so. */
export function sizeOfAspect(aspect: number, pixels: number): { width: number; height: number } {
  const side = (length: number) => Math.max(kStep, kStep * Math.round(length / kStep));
  const width = side(Math.sqrt(pixels * aspect));
  return { width, height: Math.max(1, Math.round(width / aspect)) };
}

/** "4:3" where the shape is one of those that have such a name, else "2.35:1". */
export function aspectText(aspect: number): string {
  const named = [[1, 1], [4, 3], [3, 2], [16, 9], [2, 1], [3, 4], [2, 3], [9, 16]].find(([w, h]) => Math.abs((aspect * h!) / w! - 1) < 0.005);
  return named ? named.join(":") : aspect >= 1 ? `${Number(aspect.toPrecision(3))}:1` : `1:${Number((1 / aspect).toPrecision(3))}`;
}
