// Developed pictures on the canvas that one sees. It is a plain 2D canvas: flipping, wiping and panning are then copies of
// pixels, which browsers do at 60 frames a second even without a graphics unit, where presenting a WebGL canvas takes
// several times a frame's time.

import type { Developer, Picture } from "./gl_develop";
import type { PixelImage } from "./pixels";
import { clamp, placed, type Box, type Point, type Size, type View } from "./view";

/** A picture in a pane; only what lies in `clip` is drawn. Boxes from the upper left, device pixels. */
export interface Piece {
  picture: Picture;
  view: View;
  pane: Box;
  clip: Box;
}

/** The zoom from which infinite pixels are large enough for their stripes. */
const kStripedFrom = 4;
const kMostStriped = 20_000;

export function present(context: CanvasRenderingContext2D, developer: Developer, background: string, pieces: Piece[]): void {
  developer.beginRound();
  const ready = pieces.map((piece) => {
    const box = placed(piece.view, piece.picture.image, piece.pane);
    const size: Size = piece.view.zoom >= 1 ? piece.picture.image : box;
    return { piece, corner: { x: piece.pane.x + box.x, y: piece.pane.y + box.y }, developed: developer.picture(piece.picture, size) };
  });
  context.fillStyle = background;
  context.fillRect(0, 0, context.canvas.width, context.canvas.height);
  for (const { piece, corner, developed } of ready) {
    if (!developed) continue;
    const zoom = Math.max(1, piece.view.zoom);
    const { clip, pane } = piece;
    context.save();
    context.beginPath();
    context.rect(clip.x, clip.y, clip.width, clip.height);
    context.clip();
    context.beginPath();
    context.rect(pane.x, pane.y, pane.width, pane.height);
    context.clip();
    const seen = copyPixels(context, developed, corner, zoom, clip);
    if (seen && piece.view.zoom >= kStripedFrom) stripe(context, piece.picture, corner, zoom, seen);
    context.restore();
  }
}

/** Pixels of the picture that lie in a box, at a zoom; gives which, or null for none. */
function copyPixels(context: CanvasRenderingContext2D, from: HTMLCanvasElement, corner: Point, zoom: number, box: Box): Box | null {
  const along = (start: number, side: number, low: number, size: number): [number, number] => [
    clamp(Math.floor((low - start) / zoom), 0, side),
    clamp(Math.ceil((low + size - start) / zoom), 0, side),
  ];
  const [x0, x1] = along(corner.x, from.width, box.x, box.width);
  const [y0, y1] = along(corner.y, from.height, box.y, box.height);
  if (x1 <= x0 || y1 <= y0) return null;
  context.imageSmoothingEnabled = false;
  context.drawImage(from, x0, y0, x1 - x0, y1 - y0, corner.x + x0 * zoom, corner.y + y0 * zoom, (x1 - x0) * zoom, (y1 - y0) * zoom);
  return { x: x0, y: y0, width: x1 - x0, height: y1 - y0 };
}

/** Stripes on pixels that are infinite, leaning to the right where positively, so that they are told apart without colour. */
function stripe(context: CanvasRenderingContext2D, { image, reference, paint }: Picture, corner: Point, zoom: number, seen: Box): void {
  const both = paint.quantity !== "pixel" && reference ? [image, reference] : [image];
  const pixels = both.flatMap((one) => infiniteIn(one, seen));
  context.lineWidth = Math.max(1, zoom / 10);
  context.strokeStyle = "#000";
  context.beginPath();
  for (const { x, y, negative } of pixels.slice(0, kMostStriped)) {
    const left = corner.x + x * zoom;
    const top = corner.y + y * zoom;
    for (const share of [0.5, 1, 1.5]) {
      // Where the line x + y = share meets the unit square.
      const [from, to] = share <= 1 ? [0, share] : [share - 1, 1];
      const [a, b] = [{ x: from, y: share - from }, { x: to, y: share - to }];
      context.moveTo(left + (negative ? 1 - a.x : a.x) * zoom, top + a.y * zoom);
      context.lineTo(left + (negative ? 1 - b.x : b.x) * zoom, top + b.y * zoom);
    }
  }
  context.stroke();
}

function infiniteIn(image: PixelImage, box: Box): { x: number; y: number; negative: boolean }[] {
  return image.statistics.infinite.flatMap(({ index, negative }) => {
    const x = index % image.width;
    const y = Math.floor(index / image.width);
    return x >= box.x && y >= box.y && x < box.x + box.width && y < box.y + box.height ? [{ x, y, negative }] : [];
  });
}

/** A part of a picture at a whole zoom; null while there is no context. */
export function enlarged(developer: Developer, picture: Picture, part: Box, zoom: number): HTMLCanvasElement | null {
  const pixels = developer.part(picture, part, part);
  if (!pixels) return null;
  const canvas = document.createElement("canvas");
  canvas.width = part.width * zoom;
  canvas.height = part.height * zoom;
  const context = canvas.getContext("2d", { alpha: false })!;
  copyPixels(context, pixels, { x: 0, y: 0 }, zoom, { x: 0, y: 0, width: canvas.width, height: canvas.height });
  if (zoom >= kStripedFrom) stripe(context, picture, { x: -part.x * zoom, y: -part.y * zoom }, zoom, part);
  return canvas;
}
