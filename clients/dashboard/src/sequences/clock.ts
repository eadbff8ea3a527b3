// The clock of players: which frame is shown when, whatever the frames' own moments are.

export interface Timed {
  /** Seconds. */
  time: number;
}

/** How long a sequence plays: until its last frame has been shown as long as the others. */
export function playSeconds(frames: Timed[], fps: number): number {
  return frames.length === 0 ? 0 : frames[frames.length - 1]!.time - frames[0]!.time + 1 / fps;
}

/** The frame shown at a time counted from the first one's; the last one stays. */
export function frameAt(frames: Timed[], seconds: number): number {
  const first = frames[0]?.time ?? 0;
  let low = 0;
  let high = frames.length;
  // A frame is shown from its moment on; a hair before counts, for times are sums of fractions.
  while (low < high) {
    const middle = (low + high) >> 1;
    if (frames[middle]!.time - first <= seconds + 1e-6) low = middle + 1;
    else high = middle;
  }
  return Math.max(0, low - 1);
}

/** The time `step` frames further, round and round. */
export function stepped(frames: Timed[], seconds: number, step: number): number {
  if (frames.length === 0) return 0;
  const next = (frameAt(frames, seconds) + step + frames.length) % frames.length;
  return frames[next]!.time - frames[0]!.time;
}
