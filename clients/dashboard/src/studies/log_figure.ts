// A figure on two logarithmic axes, as SVG. All looks are presentation attributes: a file of it needs no style sheet, and
// the page's policy permits none.

import { labelPlaces } from "./label_places";
import { kBoundSymbol } from "./symbols";

const kSvg = "http://www.w3.org/2000/svg";

export type Attributes = Record<string, string | number | undefined>;

export function svgElement(name: string, attributes: Attributes, text?: string): SVGElement {
  const made = document.createElementNS(kSvg, name);
  for (const [key, value] of Object.entries(attributes)) if (value !== undefined) made.setAttribute(key, String(value));
  if (text !== undefined) made.textContent = text;
  return made;
}

/** A logarithmic axis on the paper. */
export class LogScale {
  constructor(
    readonly domain: [number, number],
    readonly range: [number, number],
  ) {}

  /** What is beyond the domain stands at its end, what has no logarithm at the lower one. */
  at(value: number): number {
    const [low, high] = this.domain;
    const share = Math.log(Math.min(Math.max(value, low), high) / low) / Math.log(high / low);
    return this.range[0] + share * (this.range[1] - this.range[0]);
  }

  /** The value at a place within the range. */
  valueAt(place: number): number {
    const [low, high] = this.domain;
    return low * (high / low) ** ((place - this.range[0]) / (this.range[1] - this.range[0]));
  }
}

export interface FigurePoint {
  x: number;
  y: number;
}

interface Ends {
  low: number;
  high: number;
}

/** What follows each other without a gap. */
function runsOf<T>(items: (T | null)[]): T[][] {
  const runs: T[][] = [[]];
  for (const item of items)
    if (item !== null) runs.at(-1)!.push(item);
    else if (runs.at(-1)!.length) runs.push([]);
  return runs.filter((run) => run.length > 0);
}

export interface FigureLook {
  width: number;
  height: number;
  text: string;
  muted: string;
  grid: string;
}

interface AxisText {
  label: string;
  ticks: number[];
  text: (value: number) => string;
}

const kMargins = { left: 64, right: 20, top: 24, bottom: 44 };
const kFontSize = 12;
const kNoteSize = 11;
const kTick = 4;
const kNameHeight = 15;

/** As wide as the widest of the fonts that the page may be shown in. */
const textWidth = (text: string): number => 0.6 * kFontSize * text.length;

export class LogFigure {
  readonly svg: SVGElement;
  readonly x: LogScale;
  readonly y: LogScale;

  /** `label`: what it is, for who does not see it. */
  constructor(
    private readonly look: FigureLook,
    label: string,
    xDomain: [number, number],
    yDomain: [number, number],
  ) {
    const { width, height } = look;
    this.svg = svgElement("svg", { width, height, viewBox: `0 0 ${width} ${height}`, role: "img", "aria-label": label, "font-size": kFontSize });
    this.x = new LogScale(xDomain, [kMargins.left, width - kMargins.right]);
    this.y = new LogScale(yDomain, [height - kMargins.bottom, kMargins.top]);
  }

  private add(name: string, attributes: Attributes, text?: string): void {
    this.svg.append(svgElement(name, attributes, text));
  }

  private path(points: FigurePoint[]): string {
    return points.map(({ x, y }, i) => `${i === 0 ? "M" : "L"}${this.x.at(x).toFixed(2)} ${this.y.at(y).toFixed(2)}`).join("");
  }

  axes(xText: AxisText, yText: AxisText): void {
    const { grid, muted, width, height } = this.look;
    const [[left, right], [bottom, top]] = [this.x.range, this.y.range];
    const xs = xText.ticks.map((tick) => ({ place: this.x.at(tick), text: xText.text(tick) }));
    const ys = yText.ticks.map((tick) => ({ place: this.y.at(tick), text: yText.text(tick) }));
    const ticks = [...xs.map(({ place }) => `M${place} ${top}V${bottom}`), ...ys.map(({ place }) => `M${left} ${place}H${right}`)];
    this.add("path", { d: `M${left} ${top}H${right}V${bottom}H${left}Z${ticks.join("")}`, fill: "none", stroke: grid });
    const marks = [...xs.map(({ place }) => `M${place} ${bottom}v${kTick}`), ...ys.map(({ place }) => `M${left} ${place}h${-kTick}`)];
    this.add("path", { d: marks.join(""), stroke: muted });
    // As many as have room beside each other.
    const gap = Math.min(...xs.slice(1).map(({ place }, i) => place - xs[i]!.place));
    const every = xs.length > 1 ? Math.ceil(Math.max(...xs.map(({ text }) => textWidth(text))) / gap) : 1;
    for (const { place, text } of xs.filter((_, i) => i % every === 0)) this.add("text", { x: place, y: bottom + 17, fill: muted, "text-anchor": "middle" }, text);
    for (const { place, text } of ys) this.add("text", { x: left - 8, y: place + 4, fill: muted, "text-anchor": "end" }, text);
    this.add("text", { x: width - kMargins.right, y: height - 6, fill: muted, "text-anchor": "end" }, xText.label);
    this.add("text", { x: 4, y: 14, fill: muted }, yText.label);
  }

  /** Ends at each point that is null, and goes on after it. */
  line(points: (FigurePoint | null)[], attributes: Attributes): void {
    for (const run of runsOf(points)) this.add("path", { d: this.path(run), fill: "none", "stroke-linejoin": "round", ...attributes });
  }

  /** Between two values of each x; a whisker where a point stands alone. Null where nothing is known. */
  band(ends: (({ x: number } & Ends) | null)[], colour: string): void {
    for (const run of runsOf(ends)) {
      const upper = run.map(({ x, high }) => ({ x, y: high }));
      const lower = run.map(({ x, low }) => ({ x, y: low }));
      if (run.length === 1) this.add("path", { d: this.path([...upper, ...lower]), stroke: colour, "stroke-width": 1.6 });
      else this.add("path", { d: `${this.path([...upper, ...lower.reverse()])}Z`, fill: colour, "fill-opacity": 0.16 });
    }
  }

  /** Across the whole figure, with what it is above it, and above the place `under`; the place of that note. */
  level(value: number, note: string, anchor: "start" | "end", attributes: Attributes, under = Infinity): number {
    const [left, right] = this.x.range;
    const y = this.y.at(value);
    const place = Math.min(y - 6, under - kNoteSize - 2);
    this.add("path", { d: `M${left} ${y.toFixed(2)}H${right}`, ...attributes });
    this.add("text", { x: anchor === "start" ? left + 4 : right - 4, y: place.toFixed(2), fill: attributes.stroke, "font-size": kNoteSize, "text-anchor": anchor }, note);
    return place;
  }

  private mark(point: FigurePoint, path: string, scale: number, attributes: Attributes): void {
    this.add("path", { d: path, transform: `translate(${this.x.at(point.x).toFixed(2)} ${this.y.at(point.y).toFixed(2)}) scale(${scale})`, ...attributes });
  }

  symbol(point: FigurePoint, path: string, colour: string, scale = 0.8): void {
    this.mark(point, path, scale, { fill: colour });
  }

  /** Where no more is known than that it is below. */
  bound(point: FigurePoint, colour: string): void {
    this.mark(point, kBoundSymbol, 1, { fill: "none", stroke: colour, "stroke-width": 1.6 });
  }

  /** Names of points, none over another. */
  names(points: (FigurePoint & { text: string })[], attributes: Attributes): void {
    const [[left, right], [bottom, top]] = [this.x.range, this.y.range];
    const width = right - left;
    const places = points.map(({ x, y }) => ({ x: this.x.at(x), y: this.y.at(y) }));
    const widths = points.map(({ text }) => textWidth(text));
    const boxes = labelPlaces(places, widths, kNameHeight, { x: left, y: top, width, height: bottom - top });
    points.forEach(({ text }, i) => {
      const box = boxes[i]!;
      // A name that is wider than the figure is narrowed to it.
      const narrowed = widths[i]! > width ? { textLength: width, lengthAdjust: "spacingAndGlyphs" } : {};
      this.add("text", { x: box.x, y: box.y + kFontSize - 1, ...narrowed, ...attributes }, text);
      const { x, y } = places[i]!;
      const middle = box.y + kNameHeight / 2;
      // Where it stands higher or lower than its point, a line leads to it.
      if (Math.abs(middle - y) > kNameHeight / 2) {
        const end = Math.min(Math.max(x, box.x), box.x + box.width);
        this.add("path", { d: `M${x} ${y}L${end} ${middle < y ? box.y + kNameHeight : box.y}`, stroke: this.look.muted, "stroke-width": 0.75 });
      }
    });
  }

  note(point: FigurePoint, offset: [x: number, y: number], text: string, attributes: Attributes): void {
    this.add("text", { x: this.x.at(point.x) + offset[0], y: this.y.at(point.y) + offset[1], ...attributes }, text);
  }
}
