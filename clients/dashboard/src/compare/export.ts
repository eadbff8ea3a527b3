// Pictures to keep: what is seen, with its scale, and the strip of crops.

import { saveBlob } from "../api/client";
import { barPaint, barTitle, paintBar } from "./colour_bar";
import { cropPicture, kCropLetters } from "./crop_strip";
import type { Desk } from "./desk";
import { ticksOf } from "./paint";
import { drawNow } from "./stage";

const kText = 13;
const kMargin = 8;
const kBarHeight = 44;

function page(width: number, height: number): CanvasRenderingContext2D {
  const canvas = document.createElement("canvas");
  canvas.width = width;
  canvas.height = height;
  const context = canvas.getContext("2d")!;
  context.fillStyle = "#ffffff";
  context.fillRect(0, 0, width, height);
  context.fillStyle = "#000000";
  context.font = `${kText}px system-ui, "Liberation Sans", sans-serif`;
  context.textBaseline = "top";
  return context;
}

async function save(context: CanvasRenderingContext2D, name: string): Promise<void> {
  const blob = await new Promise<Blob | null>((done) => context.canvas.toBlob(done, "image/png"));
  if (!blob) throw new Error("the browser could not make a PNG of this size");
  saveBlob(blob, name);
}

function drawScale(context: CanvasRenderingContext2D, desk: Desk, top: number): void {
  const paint = barPaint(desk);
  const title = barTitle(desk);
  context.textAlign = "left";
  context.fillText(title, kMargin, top + kMargin);
  const from = kMargin + Math.max(120, context.measureText(title).width + 16);
  const width = Math.max(64, Math.min(480, context.canvas.width - from - 32));
  paintBar(context, paint, { x: from, y: top + kMargin, width, height: 12 });
  context.fillStyle = "#000000";
  context.textAlign = "center";
  for (const { place, text } of ticksOf(paint)) context.fillText(text, from + place * width, top + kMargin + 15);
  context.textAlign = "left";
}

/** Whether colours are other than the picture's own, so that numbers must go with them. */
const needsScale = (desk: Desk): boolean => barPaint(desk).colours !== "tone";

/** The panes as they are seen, pixel for pixel; below them the scale, where colours stand for values. */
export async function saveView(desk: Desk, canvas: HTMLCanvasElement): Promise<void> {
  const scale = needsScale(desk) ? kBarHeight : 0;
  const context = page(canvas.width, canvas.height + scale);
  drawNow(desk, canvas);
  context.drawImage(canvas, 0, 0);
  if (scale) drawScale(context, desk, canvas.height);
  await save(context, "photond-view.png");
}

/** A row for each crop, a column for each image. */
export async function saveCrops(desk: Desk): Promise<void> {
  const { crops, images, cropZoom } = desk.look.peek();
  const widest = Math.max(...crops.map((crop) => crop.width * cropZoom), 96);
  const heading = kText + 2 * kMargin;
  const heights = crops.map((crop) => crop.height * cropZoom + kMargin);
  const scale = needsScale(desk) ? kBarHeight : 0;
  const left = kText + 2 * kMargin;
  const context = page(left + images.length * (widest + kMargin), heading + heights.reduce((sum, height) => sum + height, 0) + scale);
  images.forEach((name, index) => {
    const title = `${index + 1} ${desk.sources.peek().get(name)?.title ?? name}${index === desk.reference.peek() && images.length > 1 ? ", reference" : ""}`;
    context.fillText(title, left + index * (widest + kMargin), kMargin, widest);
  });
  let top = heading;
  crops.forEach((crop, row) => {
    context.fillText(kCropLetters[row]!, kMargin, top);
    images.forEach((_, index) => {
      const picture = cropPicture(desk, index, crop, cropZoom);
      if (picture) context.drawImage(picture, left + index * (widest + kMargin), top);
    });
    top += heights[row]!;
  });
  if (scale) drawScale(context, desk, top);
  await save(context, "photond-crops.png");
}
