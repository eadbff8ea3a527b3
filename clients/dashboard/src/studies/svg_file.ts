// A figure as an SVG file that stands by itself: its fonts named, its colours those of light paper, its legend inside.

import { seriesLook } from "../ui/palette";

const kSvg = "http://www.w3.org/2000/svg";
const kFont = "Liberation Sans, Arial, Helvetica, sans-serif";
const kLegendLine = 20;
const kPadding = 16;

export interface LegendEntry {
  row: number;
  name: string;
}

function element(name: string, attributes: Record<string, string | number>, text?: string): SVGElement {
  const made = document.createElementNS(kSvg, name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, String(value));
  if (text !== undefined) made.textContent = text;
  return made;
}

function legendOf(entries: LegendEntry[], top: number): SVGElement[] {
  return entries.flatMap(({ row, name }, i) => {
    const { colour, dash } = seriesLook(row, false);
    const y = top + i * kLegendLine;
    return [
      element("line", { x1: 64, x2: 96, y1: y, y2: y, stroke: colour, "stroke-width": 2, ...(dash.length ? { "stroke-dasharray": dash.join(" ") } : {}) }),
      element("text", { x: 104, y: y + 4, "font-size": 12, "text-anchor": "start", fill: "#15202b" }, name),
    ];
  });
}

/** The text of an SVG file of what Plot drew in its light look. */
export function svgFile(drawn: Element, title: string, legend: LegendEntry[]): string {
  const svg = drawn.cloneNode(true) as SVGSVGElement;
  svg.querySelectorAll("style").forEach((style) => style.remove());
  svg.removeAttribute("class");
  svg.removeAttribute("style");
  const width = Number(svg.getAttribute("width"));
  const height = Number(svg.getAttribute("height"));
  const whole = height + (legend.length ? legend.length * kLegendLine + kPadding : 0);
  svg.setAttribute("height", String(whole));
  svg.setAttribute("viewBox", `0 0 ${width} ${whole}`);
  svg.setAttribute("font-family", kFont);
  svg.setAttribute("xmlns", kSvg);
  svg.prepend(element("title", {}, title), element("rect", { width, height: whole, fill: "#ffffff" }));
  svg.append(...legendOf(legend, height + kPadding / 2));
  return `<?xml version="1.0" encoding="UTF-8"?>\n${new XMLSerializer().serializeToString(svg)}\n`;
}
