// A figure as an SVG file that stands by itself: its fonts named, its colours those of light paper, its legend inside.

import { seriesLook } from "../ui/palette";
import { svgElement } from "./log_figure";

const kFont = "Liberation Sans, Arial, Helvetica, sans-serif";
const kLegendLine = 20;
const kPadding = 16;

export interface LegendEntry {
  row: number;
  name: string;
}

function legendOf(entries: LegendEntry[], top: number): SVGElement[] {
  return entries.flatMap(({ row, name }, i) => {
    const { colour, dash } = seriesLook(row, false);
    const y = top + i * kLegendLine;
    return [
      svgElement("line", { x1: 64, x2: 96, y1: y, y2: y, stroke: colour, "stroke-width": 2, "stroke-dasharray": dash.length ? dash.join(" ") : undefined }),
      svgElement("text", { x: 104, y: y + 4, "font-size": 12, "text-anchor": "start", fill: "#15202b" }, name),
    ];
  });
}

/** The text of an SVG file of a figure in its light look. */
export function svgFile(drawn: Element, title: string, legend: LegendEntry[]): string {
  const svg = drawn.cloneNode(true) as SVGSVGElement;
  const width = Number(svg.getAttribute("width"));
  const height = Number(svg.getAttribute("height"));
  const whole = height + (legend.length ? legend.length * kLegendLine + kPadding : 0);
  svg.setAttribute("height", String(whole));
  svg.setAttribute("viewBox", `0 0 ${width} ${whole}`);
  svg.setAttribute("font-family", kFont);
  svg.prepend(svgElement("title", {}, title), svgElement("rect", { width, height: whole, fill: "#ffffff" }));
  svg.append(...legendOf(legend, height + kPadding / 2));
  return `<?xml version="1.0" encoding="UTF-8"?>\n${new XMLSerializer().serializeToString(svg)}\n`;
}
