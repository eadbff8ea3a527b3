// What a room shows is in its address, so that a link and the back button bring it back.

import { useLocation } from "preact-iso";
import { useCallback } from "preact/hooks";

/** The address's query and how to change some of it. A change replaces the address, unless it is a step to come back from. */
export function useQuery(): [Record<string, string>, (change: Record<string, string | null | undefined>, step?: boolean) => void] {
  const location = useLocation();
  const change = useCallback(
    (members: Record<string, string | null | undefined>, step = false) => {
      // From the address itself: two changes before a rendering must both be in it.
      const query = new URLSearchParams(window.location.search);
      for (const [name, value] of Object.entries(members))
        if (value === null || value === undefined || value === "") query.delete(name);
        else query.set(name, value);
      const text = query.toString();
      location.route(window.location.pathname + (text ? `?${text}` : ""), !step);
    },
    [location],
  );
  return [location.query, change];
}
