// Half floats (IEEE 754 binary16), as the daemon sends pixels.

function decode(bits: number): number {
  const sign = bits & 0x8000 ? -1 : 1;
  const exponent = (bits >> 10) & 0x1f;
  const fraction = bits & 0x3ff;
  if (exponent === 0) return sign * fraction * 2 ** -24;
  if (exponent === 31) return fraction ? NaN : sign * Infinity;
  return sign * (1 + fraction / 1024) * 2 ** (exponent - 15);
}

let table: Float32Array | null = null;

/** The value of each of the 65536 halves, by its bits. */
export function halfTable(): Float32Array {
  if (!table) {
    table = new Float32Array(65536);
    for (let bits = 0; bits < 65536; ++bits) table[bits] = decode(bits);
  }
  return table;
}

/** The largest finite half: the daemon turns what is beyond it into infinity, and says how often it did. */
export const kGreatestHalf = 65504;
