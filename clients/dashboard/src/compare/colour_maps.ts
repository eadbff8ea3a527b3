// Colours for values, made as the daemon makes them for error.png and flip.png (renderer/error/color_map.cpp): paths
// through cylindrical CIELAB whose lightness rises evenly, so that they read without colour vision too.

type Triple = [number, number, number];

/** Linear Rec.709 from X/Xn, Y/Yn, Z/Zn of its white D65, from the standard's chromaticities. */
const kRgbFromXyz = ((): Triple[] => {
  const x = [0.64, 0.3, 0.15, 0.3127];
  const y = [0.33, 0.6, 0.06, 0.329];
  const xyz = [x.map((value, i) => value / y[i]!), [1, 1, 1, 1], x.map((value, i) => (1 - value - y[i]!) / y[i]!)];
  const primaries = xyz.map((row) => row.slice(0, 3) as Triple);
  const white = xyz.map((row) => row[3]!);
  const shares = inverse(primaries).map((row) => row.reduce((sum, value, i) => sum + value * white[i]!, 0));
  return inverse(primaries.map((row, i) => row.map((value, j) => (value * shares[j]!) / white[i]!) as Triple));
})();

function inverse(m: Triple[]): Triple[] {
  const cofactor = (i: number, j: number) => {
    const [i1, i2, j1, j2] = [(i + 1) % 3, (i + 2) % 3, (j + 1) % 3, (j + 2) % 3];
    return m[i1]![j1]! * m[i2]![j2]! - m[i1]![j2]! * m[i2]![j1]!;
  };
  const determinant = m[0]![0] * cofactor(0, 0) + m[0]![1] * cofactor(0, 1) + m[0]![2] * cofactor(0, 2);
  return [0, 1, 2].map((j) => [0, 1, 2].map((i) => cofactor(i, j) / determinant) as Triple);
}

interface Lch {
  lightness: number;
  chroma: number;
  /** Degrees: about 320 purple, 40 red, 65 orange, 100 yellow, 220 cyan, 285 blue. */
  hue: number;
}

function linearRgb({ lightness, chroma, hue }: Lch): Triple {
  const angle = (hue * Math.PI) / 180;
  const fy = (lightness + 16) / 116;
  const xyz = [fy + (chroma * Math.cos(angle)) / 500, fy, fy - (chroma * Math.sin(angle)) / 200].map((f) =>
    f > 6 / 29 ? f ** 3 : 3 * (6 / 29) ** 2 * (f - 4 / 29),
  );
  return kRgbFromXyz.map((row) => row[0] * xyz[0]! + row[1] * xyz[1]! + row[2] * xyz[2]!) as Triple;
}

const displayable = (rgb: Triple) => rgb.every((value) => value >= 0 && value <= 1);

/** The colour, or with less chroma if no display shows it: lightness and hue stay. */
function nearestDisplayable(colour: Lch): Triple {
  const rgb = linearRgb(colour);
  if (displayable(rgb)) return rgb;
  let inside = 0;
  let outside = colour.chroma;
  for (let step = 0; step < 30; ++step) {
    const chroma = 0.5 * (inside + outside);
    if (displayable(linearRgb({ ...colour, chroma }))) inside = chroma;
    else outside = chroma;
  }
  return linearRgb({ ...colour, chroma: inside });
}

export const srgbEncode = (linear: number): number => (linear <= 0.0031308 ? 12.92 * linear : 1.055 * linear ** (1 / 2.4) - 0.055);

/** Cubic curve through values at even steps over [0, 1] (Catmull and Rom; level beyond the ends). */
function curveThrough(values: number[], t: number): number {
  const place = t * (values.length - 1);
  const i = Math.min(Math.floor(place), values.length - 2);
  const u = place - i;
  const p0 = values[Math.max(i - 1, 0)]!;
  const p1 = values[i]!;
  const p2 = values[i + 1]!;
  const p3 = values[Math.min(i + 2, values.length - 1)]!;
  return p1 + 0.5 * u * (p2 - p0 + u * (2 * p0 - 5 * p1 + 4 * p2 - p3 + u * (3 * (p1 - p2) + p3 - p0)));
}

/** RGBA of `size` entries over [0, 1]. */
function mapOf(size: number, colourAt: (t: number) => Lch): Uint8Array {
  const map = new Uint8Array(4 * size);
  for (let i = 0; i < size; ++i) {
    const rgb = nearestDisplayable(colourAt(i / (size - 1)));
    rgb.forEach((value, k) => (map[4 * i + k] = Math.round(255 * srgbEncode(Math.min(1, Math.max(0, value))))));
    map[4 * i + 3] = 255;
  }
  return map;
}

export interface ColourMap {
  /** RGBA entries at even steps over the scale. */
  rgba: Uint8Array;
  /** Whether colours between two entries are mixed; otherwise the nearest is taken. */
  mixed: boolean;
}

const kChroma = [0, 36, 49, 59, 74, 78, 66, 46, 12];

/**
 * Maps that others know, as polynomials through their tables, red, green and blue of the display's own signal, from the
 * constant up: those of matplotlib [van der Walt and Smith 2015] of degree 6, to some 3 of 255 [Zucker 2019], and turbo of
 * degree 5 [Mikhailov 2019].
 */
const kPolynomials = {
  viridis: [
    [0.2777273, 0.1050930, -0.3308618, -4.6342305, 6.2282699, 4.7763850, -5.4354559],
    [0.0054073, 1.4046135, 0.2148476, -5.7991010, 14.1799334, -13.7451454, 4.6458526],
    [0.3340998, 1.3845902, 0.0950952, -19.3324410, 56.6905526, -65.3530326, 26.3124352],
  ],
  magma: [
    [-0.0021365, 0.2516605, 8.3537173, -27.6687331, 52.1761398, -50.7685254, 18.6557051],
    [-0.0007497, 0.6775232, -3.5777195, 14.2647308, -27.9436061, 29.0465828, -11.4897735],
    [-0.0053861, 2.4940266, 0.3144680, -13.6492132, 12.9441694, 4.2341530, -5.6019615],
  ],
  inferno: [
    [0.0002189, 0.1065134, 11.6024931, -41.7039961, 77.1629357, -71.3194282, 25.1311262],
    [0.0016510, 0.5639564, -3.9728540, 17.4363989, -33.4023589, 32.6260643, -12.2426690],
    [-0.0194809, 3.9327124, -15.9423941, 44.3541452, -81.8073093, 73.2095199, -23.0703250],
  ],
  plasma: [
    [0.0587323, 2.1765146, -2.6894605, 6.1303483, -11.1074362, 10.0230656, -3.6587138],
    [0.0233367, 0.2383834, -7.4558511, 42.3461881, -82.6663111, 71.4136177, -22.9315347],
    [0.5433402, 0.7539605, 3.1107999, -28.5188547, 60.1398477, -54.0721866, 18.1919078],
  ],
  turbo: [
    [0.1357214, 4.6153926, -42.6603226, 132.1310823, -152.9423940, 59.2863794],
    [0.0914026, 2.1941884, 4.8429666, -14.1850333, 4.2772986, 2.8295660],
    [0.1066733, 12.6419461, -60.5820484, 110.3627677, -89.9031091, 27.3482497],
  ],
} satisfies Record<string, number[][]>;

function polynomialMap(channels: number[][]): ColourMap {
  const rgba = new Uint8Array(4 * 256);
  for (let i = 0; i < 256; ++i) {
    channels.forEach((factors, k) => {
      const value = factors.reduceRight((sum, factor) => (sum * i) / 255 + factor, 0);
      rgba[4 * i + k] = Math.round(255 * Math.min(1, Math.max(0, value)));
    });
    rgba[4 * i + 3] = 255;
  }
  return { rgba, mixed: false };
}

export type MapName = "magnitude" | "signed" | "heat" | keyof typeof kPolynomials | "grey";

const makers: Record<MapName, () => ColourMap> = {
  viridis: () => polynomialMap(kPolynomials.viridis),
  magma: () => polynomialMap(kPolynomials.magma),
  inferno: () => polynomialMap(kPolynomials.inferno),
  plasma: () => polynomialMap(kPolynomials.plasma),
  turbo: () => polynomialMap(kPolynomials.turbo),
  // Of even steps in lightness too: a display's signal is nearly that.
  grey: () => ({ rgba: mapOf(256, (t) => ({ lightness: 100 * t, chroma: 0, hue: 0 })), mixed: false }),
  // Dark to bright over purple, red, orange and yellow; entry for entry the daemon's.
  magnitude: () => ({
    rgba: mapOf(256, (t) => ({ lightness: 2 + 96 * t, chroma: curveThrough(kChroma, t), hue: 285 + 178 * t ** 0.8 })),
    mixed: false,
  }),
  // Black in the middle: blue to pale cyan below, red to pale yellow above, of equal lightness on both sides.
  signed: () => ({
    rgba: mapOf(513, (t) => {
      const side = 2 * t - 1;
      const size = Math.abs(side);
      return { lightness: 2 + 92 * size, chroma: curveThrough([0, 48, 66, 70, 60, 30], size), hue: side < 0 ? 288 - 78 * size : 30 + 70 * size };
    }),
    mixed: false,
  }),
  // Splats over a pixel, by the colours of the photon-splatting thesis: blue 0, green 200, red 400, white 600.
  heat: () => ({ rgba: new Uint8Array([0, 0, 255, 255, 0, 255, 0, 255, 255, 0, 0, 255, 255, 255, 255, 255]), mixed: true }),
};

const made = new Map<MapName, ColourMap>();

export function colourMap(name: MapName): ColourMap {
  let map = made.get(name);
  if (!map) made.set(name, (map = makers[name]()));
  return map;
}

/** The colour at a place in [0, 1]: red, green and blue, 0 to 255. */
export function colourAt({ rgba, mixed }: ColourMap, place: number): Triple {
  const last = rgba.length / 4 - 1;
  const t = Math.min(1, Math.max(0, place)) * last;
  const below = mixed ? Math.min(Math.floor(t), last - 1) : Math.round(t);
  const share = mixed ? t - below : 0;
  return [0, 1, 2].map((k) => {
    const first = rgba[4 * below + k]!;
    return share === 0 ? first : Math.round((1 - share) * first + share * rgba[4 * (below + 1) + k]!);
  }) as Triple;
}
