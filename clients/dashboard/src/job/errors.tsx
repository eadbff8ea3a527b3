// The errors of a job at its end, and how they were measured.

import type { Statistics } from "../api/types";
import { errorWithInterval } from "../ui/error_interval";
import { numberText } from "../ui/format";
import { measuredOf, measuringText } from "./measured";

/** With what of them is the reference's own noise, where that has a part in them. */
export function Errors({ statistics }: { statistics: Statistics }) {
  if (!statistics.error) return null;
  const rows = measuredOf(statistics);
  const { reference } = statistics;
  const hasOwn = rows.some((row) => row.own !== null);
  return (
    <>
      <p class="hint">{measuringText(reference, hasOwn)}</p>
      <details class="job-errors">
        <summary>All that was measured at the end</summary>
        <table class="job-table">
          <thead>
            <tr>
              <th>Metric</th>
              <th class="number">Value</th>
              {hasOwn && <th class="number">Of the reference itself</th>}
            </tr>
          </thead>
          <tbody>
            {rows.map(({ name, value, interval, own }) => (
              <tr key={name}>
                <td>{name}</td>
                <td class="number">{errorWithInterval(value, interval)}</td>
                {hasOwn && <td class="number">{numberText(own)}</td>}
              </tr>
            ))}
          </tbody>
        </table>
        {reference && reference.notes.length > 0 && (
          <ul class="hint">
            {reference.notes.map((note) => (
              <li key={note}>{note}</li>
            ))}
          </ul>
        )}
      </details>
    </>
  );
}
