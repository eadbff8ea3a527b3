// A place on the page with a chart by uPlot in it: fetched when the first is shown, as wide as its place, in the theme's
// colours.

import type { RefObject } from "preact";
import { useEffect, useRef } from "preact/hooks";
import type uPlot from "uplot";

import { isDark } from "../app/theme";

/** Where nothing has been laid out yet. */
const kSomeWidth = 200;

/**
 * The place for a chart. It is made anew when a member of `remake` or the theme changes, and given new data when a member
 * of `refill` does; both functions are those of the last rendering.
 */
export function useUPlot(
  options: (Chart: typeof uPlot, width: number) => uPlot.Options,
  data: () => uPlot.AlignedData,
  remake: unknown[],
  refill: unknown[],
): RefObject<HTMLDivElement> {
  const place = useRef<HTMLDivElement>(null);
  const chart = useRef<uPlot | null>(null);
  const latest = useRef({ options, data });
  latest.current = { options, data };
  useEffect(() => {
    let gone = false;
    const sizes = new ResizeObserver(([entry]) => {
      const width = entry?.target.clientWidth;
      if (width && chart.current) chart.current.setSize({ width, height: chart.current.height });
    });
    void import("uplot").then(({ default: Chart }) => {
      const element = place.current;
      if (gone || !element) return;
      chart.current = new Chart(latest.current.options(Chart, element.clientWidth || kSomeWidth), latest.current.data(), element);
      sizes.observe(element);
    });
    return () => {
      gone = true;
      sizes.disconnect();
      chart.current?.destroy();
      chart.current = null;
    };
  }, [...remake, isDark.value]);
  useEffect(() => chart.current?.setData(latest.current.data()), refill);
  return place;
}
