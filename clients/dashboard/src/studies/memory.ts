// What rows come to at their end: memory against error, and which are worth their memory.

import type { ComparisonRow } from "../api/types";
import { drawnError } from "../ui/error_interval";
import { rowName } from "./series";

export interface MemoryPoint {
  row: number;
  name: string;
  bytes: number;
  error: number;
  /** The error is not told apart from 0: `error` is what it is below. */
  isBound: boolean;
}

/** Of the rows whose memory and last error are known. */
export function memoryPoints(rows: ComparisonRow[], metric: string, hidden: ReadonlySet<number>): MemoryPoint[] {
  return rows.flatMap((row, index) => {
    const bytes = row.peak_bytes;
    const drawn = drawnError(row.error[metric]?.value, row.error[metric]?.interval);
    return bytes && drawn && !hidden.has(index) ? [{ row: index, name: rowName(row), bytes, error: drawn.at, isBound: drawn.isBound }] : [];
  });
}

const beats = (a: MemoryPoint, b: MemoryPoint): boolean =>
  a.bytes <= b.bytes && a.error <= b.error && (a.bytes < b.bytes || a.error < b.error);

/** Points that no other is as small and as good as, by rising memory. */
export const memoryFront = (points: MemoryPoint[]): MemoryPoint[] =>
  points.filter((one) => !points.some((other) => beats(other, one))).sort((a, b) => a.bytes - b.bytes);
