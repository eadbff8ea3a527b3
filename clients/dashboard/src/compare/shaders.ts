// Display colours of values: a pixel of the result is one of the image or, below a zoom of 1, the mean over the area of
// a device pixel.

import { kAcesIn, kAcesOut, kAgxContrast, kAgxHigh, kAgxIn, kAgxLow, kAgxOut, kNeutralDesaturation, kNeutralF90, kNeutralStart } from "./view_transforms";

export const kWholeCanvas = `#version 300 es
void main() {
  gl_Position = vec4(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0, 0.0, 1.0);
}`;

const number = (x: number): string => (Number.isInteger(x) ? `${x}.0` : String(x));
/** By columns, as the shader has them. */
const matrix = (m: readonly (readonly number[])[]): string => `mat3(${[0, 1, 2].flatMap((column) => m.map((row) => number(row[column]!))).join(", ")})`;

/** Numbers of Paint's words in the shader. */
export const kQuantity = { pixel: 0, signed: 1, relative: 2 } as const;
export const kColours = { tone: 0, straight: 1, map: 2, log: 3 } as const;
export const kCurve = { srgb: 0, filmic: 1, linear: 2, aces: 3, agx: 4, neutral: 5 } as const;
export const kChannel = { rgb: 0, r: 1, g: 2, b: 3, luminance: 4 } as const;

// NaN is magenta, infinity cyan, negative infinity dark cyan. Whether a value is finite is read from its bits, for
// compilers may take it that all numbers are.
export const kDevelop = `#version 300 es
precision highp float;
precision highp int;
precision highp sampler2D;
uniform sampler2D uImage, uReference, uMap;
uniform ivec2 uSize;    // of the images
uniform ivec2 uOrigin;  // the first pixel shown
uniform vec2 uTile;     // the first pixel of the result that is drawn, of a result too large to be drawn at once
uniform float uHeight;  // of what is drawn: row 0 is its uppermost
uniform vec2 uStep;     // pixels of the image to one of the result
uniform bool uGrey;     // one channel only
uniform int uQuantity, uColours, uCurve, uChannel;
uniform float uScale, uLow, uHigh, uFloor;
uniform int uMapLast;
uniform bool uMapMixed;
out vec4 colour;

bool isNan(float x) { return (floatBitsToUint(x) & 0x7fffffffu) > 0x7f800000u; }
bool isInfinite(float x) { return (floatBitsToUint(x) & 0x7fffffffu) == 0x7f800000u; }

vec3 fetch(sampler2D image, ivec2 at) {
  vec3 value = texelFetch(image, at, 0).rgb;
  return uGrey ? value.rrr : value;
}

// A channel that is not looked at does not count, be it NaN.
vec3 chosen(vec3 value) {
  if (uChannel == 1) return value.rrr;
  if (uChannel == 2) return value.ggg;
  if (uChannel == 3) return value.bbb;
  if (uChannel == 4) return vec3(value.r * 0.2126 + value.g * 0.7152 + value.b * 0.0722);
  return value;
}

// What is to be seen of NaN and infinities: 1 NaN, 2 infinity, 4 negative infinity.
int marksOf(vec3 value) {
  int marks = 0;
  for (int k = 0; k < 3; ++k) {
    bool counts = uChannel == 0 || uChannel == 4 || k == uChannel - 1;
    if (!counts) continue;
    if (isNan(value[k])) marks |= 1;
    else if (isInfinite(value[k])) marks |= value[k] > 0.0 ? 2 : 4;
  }
  return marks;
}

vec3 quantityAt(ivec2 at, inout int marks) {
  vec3 value = fetch(uImage, at);
  int here = marksOf(value);
  if (uQuantity == 0) {
    marks |= here;
    return here == 0 ? chosen(value) : vec3(0.0);
  }
  vec3 reference = fetch(uReference, at);
  int there = marksOf(reference);
  marks |= here | there;
  if ((here | there) != 0) return vec3(0.0);
  vec3 x = chosen(value), r = chosen(reference);
  if (uQuantity == 1) return x - r;
  vec3 d = x - r, square = r * r + uFloor;
  if (min(square.r, min(square.g, square.b)) <= 0.0) {
    marks |= 1;  // nothing to be relative to
    return vec3(0.0);
  }
  vec3 relative = d * d / square;
  return vec3(sqrt((relative.r + relative.g + relative.b) / 3.0));
}

vec3 mapped(float place) {
  float t = clamp(place, 0.0, 1.0) * float(uMapLast);
  if (!uMapMixed) return texelFetch(uMap, ivec2(int(t + 0.5), 0), 0).rgb;
  int below = min(int(t), uMapLast - 1);
  return mix(texelFetch(uMap, ivec2(below, 0), 0).rgb, texelFetch(uMap, ivec2(below + 1, 0), 0).rgb, t - float(below));
}

// Those of view_transforms.ts.
vec3 acesFitted(vec3 light) {
  vec3 v = ${matrix(kAcesIn)} * light;
  return ${matrix(kAcesOut)} * ((v * (v + 0.0245786) - 0.000090537) / (v * (0.983729 * v + 0.432951) + 0.238081));
}
vec3 agx(vec3 light) {
  vec3 place = (clamp(log2(max(${matrix(kAgxIn)} * light, 1e-10)), ${kAgxLow}, ${kAgxHigh}) - ${number(kAgxLow)}) / ${number(kAgxHigh - kAgxLow)};
  vec3 sum = vec3(0.0);
  ${[...kAgxContrast].reverse().map((factor) => `sum = sum * place + ${number(factor)};`).join("\n  ")}
  return ${matrix(kAgxOut)} * sum;
}
vec3 pbrNeutral(vec3 light) {
  float least = min(light.r, min(light.g, light.b));
  vec3 color = light - (least < ${2 * kNeutralF90} ? least - least * least / ${4 * kNeutralF90} : ${kNeutralF90});
  float peak = max(color.r, max(color.g, color.b));
  if (peak < ${kNeutralStart}) return color;
  const float room = 1.0 - ${kNeutralStart};
  float newPeak = 1.0 - room * room / (peak + room - ${kNeutralStart});
  return mix(color * newPeak / peak, vec3(newPeak), 1.0 - 1.0 / (${kNeutralDesaturation} * (peak - newPeak) + 1.0));
}

vec3 toned(vec3 light) {
  vec3 x = clamp(light * uScale, 0.0, 1e6);
  if (uCurve == 1) {
    x = min(x * 0.6, 1e4);
    x = x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14);
  }
  else if (uCurve == 3) x = acesFitted(x);
  else if (uCurve == 4) x = agx(x);
  else if (uCurve == 5) x = pbrNeutral(x);
  x = clamp(x, 0.0, 1.0);
  if (uCurve == 2 || uCurve == 4) return x;
  return mix(1.055 * pow(max(x, 0.0031308), vec3(1.0 / 2.4)) - 0.055, 12.92 * x, vec3(lessThanEqual(x, vec3(0.0031308))));
}

void main() {
  vec2 target = uTile + floor(vec2(gl_FragCoord.x, uHeight - gl_FragCoord.y));
  vec2 from = target * uStep, to = (target + 1.0) * uStep;
  ivec2 first = ivec2(from), last = min(ivec2(ceil(to)), uSize - uOrigin) - 1;
  vec3 sum = vec3(0.0);
  float weight = 0.0;
  int marks = 0;
  for (int y = first.y; y <= last.y; ++y) {
    float height = min(to.y, float(y + 1)) - max(from.y, float(y));
    for (int x = first.x; x <= last.x; ++x) {
      float share = height * (min(to.x, float(x + 1)) - max(from.x, float(x)));
      sum += share * quantityAt(uOrigin + ivec2(x, y), marks);
      weight += share;
    }
  }
  // One NaN below a pixel shows, however many pixels are averaged with it.
  if (marks != 0) {
    colour = (marks & 1) != 0 ? vec4(1.0, 0.0, 1.0, 1.0) : (marks & 2) != 0 ? vec4(0.0, 1.0, 1.0, 1.0) : vec4(0.0, 0.4, 0.45, 1.0);
    return;
  }
  vec3 value = sum / weight;
  if (uColours == 0) colour = vec4(toned(value), 1.0);
  else if (uColours == 1) colour = vec4(clamp((value - uLow) / (uHigh - uLow), 0.0, 1.0), 1.0);
  else if (uColours == 2) colour = vec4(mapped((value.r - uLow) / (uHigh - uLow)), 1.0);
  else colour = vec4(mapped(value.r <= uLow ? 0.0 : log(value.r / uLow) / log(uHigh / uLow)), 1.0);
}`;
