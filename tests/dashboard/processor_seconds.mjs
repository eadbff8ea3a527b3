// What this process and all that it has started have cost.

import { readdirSync, readFileSync } from "node:fs";

const kTicksPerSecond = 100; // of /proc, on every Linux that Debian has

/** [parent, ticks of its own and of the children that it has waited for] of a process; null for one that is gone. */
function standing(pid) {
  try {
    const text = readFileSync(`/proc/${pid}/stat`, "latin1");
    const fields = text.slice(text.lastIndexOf(")") + 2).split(" ");
    return [Number(fields[1]), fields.slice(11, 15).reduce((sum, ticks) => sum + Number(ticks), 0)];
  } catch {
    return null;
  }
}

/** Processor seconds of this process, its children and theirs, alive or waited for. */
export function processorSeconds() {
  const known = new Map();
  for (const name of readdirSync("/proc")) if (/^\d+$/.test(name)) known.set(Number(name), standing(name));
  const isOurs = (pid) => pid === process.pid || (known.get(pid) && isOurs(known.get(pid)[0]));
  let ticks = 0;
  for (const [pid, found] of known) if (found && isOurs(pid)) ticks += found[1];
  return ticks / kTicksPerSecond;
}
