import type { JobRequest } from "../api/types";
import { numberText, secondsText } from "./format";

/** The moment a request is about: "1.5 s into “walk”, the shutter open for 20 ms". Null: the scene at rest. */
export function momentText({ animation, time, shutter }: Pick<JobRequest, "animation" | "time" | "shutter">): string | null {
  if ((animation ?? null) === null && !time && !shutter) return null;
  const which = typeof animation === "string" ? `“${animation}”` : `animation ${animation ?? 0}`;
  return `${numberText(time ?? 0, 6)} s into ${which}${shutter ? `, the shutter open for ${secondsText(shutter)}` : ""}`;
}
