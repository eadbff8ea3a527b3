// The request as the daemon understood it. What was asked for stands out; what is as by default can be looked at too.

import { useState } from "preact/hooks";

import type { Job, Json, Method } from "../api/types";
import { plainName } from "../ui/format";
import { minimalRequest } from "../ui/job_request";

function textOf(value: Json): string {
  if (value === null) return "not given";
  if (Array.isArray(value)) return value.length === 0 ? "none" : value.map(textOf).join(", ");
  return typeof value === "string" ? value : typeof value === "object" ? "none" : String(value);
}

/** Members by path, objects opened up. */
function leaves(value: Json, path: string[] = []): [string[], Json][] {
  const inside = value !== null && typeof value === "object" && !Array.isArray(value) ? Object.entries(value) : [];
  return inside.length === 0 ? [[path, value]] : inside.flatMap(([name, member]) => leaves(member, [...path, name]));
}

/** What one looks for first comes first. */
const kOrder = ["scene", "camera", "animation", "time", "shutter", "image", "method", "stop", "reference", "metrics", "layers", "seed", "priority", "labels"];
const rankOf = (name: string): number => (kOrder.includes(name) ? kOrder.indexOf(name) : kOrder.length);

export function RequestPanel({ job, methods }: { job: Job; methods: Method[] }) {
  const [all, setAll] = useState(false);
  const request = job.request as unknown as Json;
  const asked = new Set(leaves(minimalRequest(job.request, methods) as unknown as Json).map(([path]) => path.join("/")));
  const rows = leaves(request).filter(([path]) => path.length > 0);
  const shown = rows.filter(([path]) => all || asked.has(path.join("/")));
  const groups = new Map<string, typeof rows>();
  for (const row of [...shown].sort((a, b) => rankOf(a[0][0]!) - rankOf(b[0][0]!))) {
    const group = row[0].length > 1 ? row[0][0]! : "";
    groups.set(group, [...(groups.get(group) ?? []), row]);
  }
  return (
    <>
      <table class="job-table job-request">
        {[...groups].map(([group, members]) => (
          <tbody key={group}>
            {group && (
              <tr>
                <th colSpan={2} scope="rowgroup">
                  {plainName(group)}
                </th>
              </tr>
            )}
            {members.map(([path, value]) => {
              const isAsked = asked.has(path.join("/"));
              return (
                <tr key={path.join("/")} class={isAsked ? "asked" : ""}>
                  <td>{plainName(path.slice(group ? 1 : 0).filter((name) => name !== "parameters").join(" › "))}</td>
                  <td>
                    {path.join("/") === "scene" ? <a href={`/scenes/${encodeURIComponent(String(value))}`}>{String(value)}</a> : textOf(value)}
                    {all && isAsked && <span class="job-asked">asked for</span>}
                  </td>
                </tr>
              );
            })}
          </tbody>
        ))}
      </table>
      <button class="quiet small" aria-expanded={all} onClick={() => setAll(!all)}>
        {all ? "Only what was asked for" : `Show the ${rows.length - shown.length} settings that are as by default`}
      </button>
    </>
  );
}
