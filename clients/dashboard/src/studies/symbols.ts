// The marks that tell entries apart, as paths about their middle, some 8 units wide.

import type { SeriesLook } from "../ui/palette";

export const kSymbols: Record<SeriesLook["symbol"], string> = {
  circle: "M4 0A4 4 0 1 1 -4 0A4 4 0 1 1 4 0Z",
  square: "M-3.5 -3.5H3.5V3.5H-3.5Z",
  triangle: "M0 -4.5L4 3.5H-4Z",
  diamond: "M0 -5L4 0L0 5L-4 0Z",
  cross: "M-4.5 -1.5H-1.5V-4.5H1.5V-1.5H4.5V1.5H1.5V4.5H-1.5V1.5H-4.5Z",
  star: "M0 -5L1.2 -1.6L4.8 -1.5L1.9 0.6L2.9 4L0 2L-2.9 4L-1.9 0.6L-4.8 -1.5L-1.2 -1.6Z",
};

/** An upper bound: an arrow down from a short line. To be stroked. */
export const kBoundSymbol = "M-5 0H5M0 0V13M-4 9L0 13L4 9";
