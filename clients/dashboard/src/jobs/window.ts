// Which rows of a long list are in view, and where they lie. Browsers hold no element higher than some 16 million pixels;
// a longer list is scrolled in proportion.

const kTallest = 12_000_000;
const kSpare = 8;

export interface Window {
  /** First and last row that are to be there, some out of view among them. */
  first: number;
  last: number;
  /** First row that is in view whole. */
  top: number;
  /** Where the first row lies. */
  offset: number;
  /** Of the whole list. */
  height: number;
}

const scaleOf = (rows: number, rowHeight: number): number => Math.min(1, kTallest / Math.max(1, rows * rowHeight));

export function windowOf(rows: number, rowHeight: number, scrollTop: number, viewHeight: number): Window {
  const scale = scaleOf(rows, rowHeight);
  const height = Math.min(rows * rowHeight, kTallest);
  // In proportion, the last row must be in view when the list is scrolled to its end.
  const most = Math.max(1, height - viewHeight);
  const from = scale === 1 ? scrollTop : (Math.min(scrollTop, most) / most) * (rows * rowHeight - viewHeight);
  const top = Math.ceil(from / rowHeight);
  const first = Math.max(0, Math.floor(from / rowHeight) - kSpare);
  const last = Math.min(rows - 1, Math.ceil((from + viewHeight) / rowHeight) + kSpare);
  return { first, last, top, offset: scrollTop - (from - first * rowHeight), height };
}

/** Where to scroll so that a row is the first in view. */
export function scrollTopOf(row: number, rows: number, rowHeight: number, viewHeight: number): number {
  const scale = scaleOf(rows, rowHeight);
  if (scale === 1) return row * rowHeight;
  return (row * rowHeight * Math.max(1, kTallest - viewHeight)) / Math.max(1, rows * rowHeight - viewHeight);
}

/** Where to scroll so that a row is in view, by as little as that takes; null where it is. */
export function scrollIntoView(row: number, rows: number, rowHeight: number, scrollTop: number, viewHeight: number): number | null {
  const { first, offset } = windowOf(rows, rowHeight, scrollTop, viewHeight);
  const at = offset + (row - first) * rowHeight - scrollTop;
  if (at >= 0 && at + rowHeight <= viewHeight) return null;
  return scrollTopOf(at < 0 ? row : row + 1 - Math.floor(viewHeight / rowHeight), rows, rowHeight, viewHeight) - (at < 0 ? 0 : viewHeight % rowHeight);
}
