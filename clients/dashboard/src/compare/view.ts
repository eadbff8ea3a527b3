// Where an image lies in a pane. Sizes of panes are in device pixels, so that a zoom of 1 is pixel for pixel.

export interface Point {
  x: number;
  y: number;
}

export interface Size {
  width: number;
  height: number;
}

export interface Box extends Point, Size {}

export interface View {
  /** Device pixels to an image pixel. */
  zoom: number;
  /** The place of the image, in its pixels, that is in the middle of the pane. */
  centre: Point;
}

export const kLeastZoom = 1 / 64;
export const kGreatestZoom = 128;
/** Zooms that a key or a button goes to. */
const kStops = [1 / 64, 1 / 32, 1 / 16, 1 / 8, 1 / 4, 1 / 2, 1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64, 96, 128];

export const clamp = (value: number, low: number, high: number): number => Math.min(high, Math.max(low, value));
export const clampZoom = (zoom: number): number => clamp(zoom, kLeastZoom, kGreatestZoom);

/** The zoom stop above or below. */
export function nextZoom(zoom: number, larger: boolean): number {
  const margin = 1 + 1e-6;
  return larger
    ? (kStops.find((stop) => stop > zoom * margin) ?? kGreatestZoom)
    : (kStops.findLast((stop) => stop < zoom / margin) ?? kLeastZoom);
}

/** The whole image in the pane: whole pixels where it is the smaller one. */
export function fitted(image: Size, pane: Size): View {
  const zoom = Math.min(pane.width / image.width, pane.height / image.height);
  return { zoom: clampZoom(zoom >= 1 ? Math.floor(zoom) : zoom), centre: { x: image.width / 2, y: image.height / 2 } };
}

/**
 * Where the image lies in the pane: its corner on a whole pixel, and below a zoom of 1 of whole pixels itself, for it is
 * then averaged to that size.
 */
export function placed(view: View, image: Size, pane: Size): Box {
  const scaled = (side: number) => (view.zoom >= 1 ? side * view.zoom : Math.max(1, Math.round(side * view.zoom)));
  return {
    x: Math.round(pane.width / 2 - view.centre.x * view.zoom),
    y: Math.round(pane.height / 2 - view.centre.y * view.zoom),
    width: scaled(image.width),
    height: scaled(image.height),
  };
}

/** The place of the image, in its pixels, at a place of the pane. */
export function imagePoint(view: View, pane: Size, at: Point): Point {
  return {
    x: (at.x - Math.round(pane.width / 2 - view.centre.x * view.zoom)) / view.zoom,
    y: (at.y - Math.round(pane.height / 2 - view.centre.y * view.zoom)) / view.zoom,
  };
}

/** The place of the pane at a place of the image. */
export function panePoint(view: View, pane: Size, at: Point): Point {
  return {
    x: Math.round(pane.width / 2 - view.centre.x * view.zoom) + at.x * view.zoom,
    y: Math.round(pane.height / 2 - view.centre.y * view.zoom) + at.y * view.zoom,
  };
}

/** Another zoom, by which what lies at a place of the pane stays there. */
export function zoomedAt(view: View, pane: Size, at: Point, zoom: number): View {
  const fixed = {
    x: view.centre.x + (at.x - pane.width / 2) / view.zoom,
    y: view.centre.y + (at.y - pane.height / 2) / view.zoom,
  };
  const next = clampZoom(zoom);
  return { zoom: next, centre: { x: fixed.x - (at.x - pane.width / 2) / next, y: fixed.y - (at.y - pane.height / 2) / next } };
}

/** Moved by device pixels; the middle of the pane stays on the image. */
export function panned(view: View, image: Size, dx: number, dy: number): View {
  return {
    zoom: view.zoom,
    centre: {
      x: clamp(view.centre.x - dx / view.zoom, 0, image.width),
      y: clamp(view.centre.y - dy / view.zoom, 0, image.height),
    },
  };
}

/** Moved as little as it takes for a pixel to be in the pane. */
export function showing(view: View, pane: Size, pixel: Point): View {
  const along = (centre: number, side: number, at: number) => {
    const reach = Math.max(0.5, side / 2 / view.zoom - 1);
    return clamp(centre, at + 0.5 - reach, at + 0.5 + reach);
  };
  return { zoom: view.zoom, centre: { x: along(view.centre.x, pane.width, pixel.x), y: along(view.centre.y, pane.height, pixel.y) } };
}

const kGap = 2;

/** Boxes for `count` images of a size, in the rows and columns that show them largest. */
export function gridOf(count: number, image: Size, stage: Size): Box[] {
  let best = { columns: 1, zoom: 0 };
  for (let columns = 1; columns <= count; ++columns) {
    const rows = Math.ceil(count / columns);
    const zoom = Math.min(stage.width / columns / image.width, stage.height / rows / image.height);
    if (zoom > best.zoom * (1 + 1e-9)) best = { columns, zoom };
  }
  const rows = Math.ceil(count / best.columns);
  const width = Math.max(1, Math.floor((stage.width - kGap * (best.columns - 1)) / best.columns));
  const height = Math.max(1, Math.floor((stage.height - kGap * (rows - 1)) / rows));
  return Array.from({ length: count }, (_, i) => ({
    x: (i % best.columns) * (width + kGap),
    y: Math.floor(i / best.columns) * (height + kGap),
    width,
    height,
  }));
}
