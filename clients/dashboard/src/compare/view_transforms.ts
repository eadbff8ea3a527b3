// View transforms of three channels at once: what a display is sent for scene-linear Rec.709 light. The shader
// (shaders.ts) has the same numbers, which it is given from here.
//
// [Khronos 2024] PBR Neutral Tone Mapper, specification and reference GLSL.
// [Hill 2016] ACES fitted, BakingLab: the reference rendering transform and the sRGB output transform in one curve.
// [Sobotka 2022] AgX; by [Wrensch 2023] Minimal AgX Implementation: its default contrast as a polynomial of degree 6,
// between matrices for Rec.709 light, no look applied.

export type Triple = [number, number, number];
/** Rows. */
type Matrix = [Triple, Triple, Triple];

const times = (m: Matrix, v: Triple): Triple => m.map((row) => row[0] * v[0] + row[1] * v[1] + row[2] * v[2]) as Triple;
const each = (v: Triple, change: (x: number) => number): Triple => v.map(change) as Triple;

export const kAcesIn: Matrix = [
  [0.59719, 0.35458, 0.04823],
  [0.076, 0.90834, 0.01566],
  [0.0284, 0.13383, 0.83777],
];
export const kAcesOut: Matrix = [
  [1.60475, -0.53108, -0.07367],
  [-0.10208, 1.10813, -0.00605],
  [-0.00327, -0.07276, 1.07602],
];

/** To linear light of the display. */
export function acesFitted(light: Triple): Triple {
  const fitted = each(times(kAcesIn, light), (v) => (v * (v + 0.0245786) - 0.000090537) / (v * (0.983729 * v + 0.432951) + 0.238081));
  return times(kAcesOut, fitted);
}

export const kAgxIn: Matrix = [
  [0.842479062253094, 0.0784335999999992, 0.0792237451477643],
  [0.0423282422610123, 0.878468636469772, 0.0791661274605434],
  [0.0423756549057051, 0.0784336, 0.879142973793104],
];
export const kAgxOut: Matrix = [
  [1.19687900512017, -0.0980208811401368, -0.0990297440797205],
  [-0.0528968517574562, 1.15190312990417, -0.0989611768448433],
  [-0.0529716355144438, -0.0980434501171241, 1.15107367264116],
];
/** Stops, log2 of light, at the ends of its curve. */
export const kAgxLow = -12.47393;
export const kAgxHigh = 4.026069;
/** From the constant up. */
export const kAgxContrast = [-0.00232, 0.1191, 0.4298, -6.868, 31.96, -40.14, 15.5];

/** To what the display is sent: its curve holds the display's own. */
export function agx(light: Triple): Triple {
  const curve = each(times(kAgxIn, light), (v) => {
    const place = (Math.min(kAgxHigh, Math.max(kAgxLow, Math.log2(Math.max(v, 1e-10)))) - kAgxLow) / (kAgxHigh - kAgxLow);
    return kAgxContrast.reduceRight((sum, factor) => sum * place + factor, 0);
  });
  return times(kAgxOut, curve);
}

/** Where highlights begin to be compressed, less what a dielectric reflects at normal incidence; and how far they lose colour. */
export const kNeutralF90 = 0.04;
export const kNeutralStart = 0.8 - kNeutralF90;
export const kNeutralDesaturation = 0.15;

/** To linear light of the display: colours below the start are as they are, but for that reflection. */
export function pbrNeutral(light: Triple): Triple {
  const least = Math.min(...light);
  const offset = least < 2 * kNeutralF90 ? least - (least * least) / (4 * kNeutralF90) : kNeutralF90;
  const color = each(light, (x) => x - offset);
  const peak = Math.max(...color);
  if (peak < kNeutralStart) return color;
  const room = 1 - kNeutralStart;
  const newPeak = 1 - (room * room) / (peak + room - kNeutralStart);
  const grey = 1 - 1 / (kNeutralDesaturation * (peak - newPeak) + 1);
  return each(color, (x) => ((x * newPeak) / peak) * (1 - grey) + newPeak * grey);
}
