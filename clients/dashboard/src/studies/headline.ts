// The one sentence that a comparison comes to, from the daemon's verdicts.

import type { ComparisonRow, Verdict } from "../api/types";
import { numberText } from "../ui/format";
import { rowName } from "./series";

export interface Headline {
  /** Whose look goes with it; null where nobody is ahead. */
  row: number | null;
  text: string;
}

/**
 * By falling error, who is ahead: one row all the way, one and then another, or nobody. Null while there is nothing to
 * judge. What is easy says little: everybody may be there at the first measurement.
 */
export function headline(verdicts: Verdict[], rows: ComparisonRow[]): Headline | null {
  const last = verdicts.at(-1);
  if (!last) return null;
  const name = (verdict: Verdict) => rowName(rows[verdict.arrived[0]!.row]!);
  const decided = verdicts.filter((verdict) => !verdict.close);
  const leaders = [...new Set(decided.map((verdict) => verdict.arrived[0]!.row))];
  if (leaders.length === 0) return { row: null, text: "Too close to call" };
  const winner = last.arrived[0]!.row;
  if (leaders.length === 1)
    return last.close
      ? { row: leaders[0]!, text: `${name(decided.at(-1)!)} is ahead at first; at ${last.metric} ${numberText(last.error)} it is too close to call` }
      : { row: winner, text: `${name(last)} is better here` };
  if (last.close) return { row: null, text: "It depends on the error you need, and for the lowest it is too close to call" };
  const before = decided.at(-2)!;
  return {
    row: winner,
    text: `It depends on the error you need: ${name(before)} is first down to ${last.metric} ${numberText(before.error)}, ${name(last)} below that`,
  };
}

/**
 * The verdict to show with the headline: of those that bear it out, the lowest error that two rows reach, for that says
 * by how much; else the lowest.
 */
export function mainVerdict(verdicts: Verdict[], winner: number | null): Verdict | null {
  const supporting = winner === null ? verdicts : verdicts.filter((verdict) => !verdict.close && verdict.arrived[0]!.row === winner);
  return supporting.filter((verdict) => verdict.arrived.length > 1).at(-1) ?? supporting.at(-1) ?? verdicts.at(-1) ?? null;
}
