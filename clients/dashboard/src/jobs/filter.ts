// The filter of the list of jobs: as words one types ("state:failed method:path_tracing label:study=x J123"), as the
// page's address has it, and as the daemon is asked.

import { kJobStates, type JobState, type JobSummary } from "../api/types";

export interface Filter {
  states: JobState[];
  method: string;
  scene: string;
  device: string;
  /** KEY or KEY=VALUE. */
  label: string;
  role: string;
  /** Jobs asked for by name; then no others are shown. */
  ids: string[];
}

export const kEverything: Filter = { states: [], method: "", scene: "", device: "", label: "", role: "", ids: [] };
export const kRoles = ["render", "reference", "merged", "frame"];

type Word = "state" | "method" | "scene" | "device" | "label" | "role";
export const kWords: Record<Word, string> = {
  state: "queued, running, succeeded, failed or cancelled; more than one with commas",
  method: "a method's name",
  scene: "a scene's name or id",
  device: "cpu, gpu:0 …",
  label: "KEY or KEY=VALUE",
  role: "render, reference, merged or frame",
};
const isWord = (text: string): text is Word => text in kWords;
const isId = (text: string): boolean => /^j\d+$/i.test(text);

export interface Token {
  text: string;
  start: number;
  end: number;
}

/** What stands between spaces; a part in double quotes may hold some. */
export function tokensOf(text: string): Token[] {
  return [...text.matchAll(/(?:[^\s"]|"[^"]*"?)+/g)].map((match) => ({
    text: match[0],
    start: match.index,
    end: match.index + match[0].length,
  }));
}

const unquoted = (text: string): string => text.replaceAll('"', "");
const quoted = (text: string): string => (/\s/.test(text) ? `"${text}"` : text);

export interface ParsedFilter {
  filter: Filter;
  faults: string[];
}

/** Reads what was typed. Words that say nothing are named and left aside. */
export function parseFilter(text: string): ParsedFilter {
  const filter: Filter = { ...kEverything, states: [], ids: [] };
  const faults: string[] = [];
  for (const token of tokensOf(text)) {
    const colon = token.text.indexOf(":");
    const word = token.text.slice(0, Math.max(0, colon)).toLowerCase();
    const value = unquoted(token.text.slice(colon + 1));
    if (isId(token.text)) {
      filter.ids.push(token.text.toUpperCase());
    } else if (!isWord(word)) {
      faults.push(`“${token.text}” is no filter: write ${Object.keys(kWords).join(":, ")}: or a job's number such as J12`);
    } else if (value === "") {
      continue; // still being typed
    } else if (word === "state") {
      for (const state of value.split(",").filter(Boolean))
        if (!kJobStates.includes(state as JobState)) faults.push(`“${state}” is none of ${kJobStates.join(", ")}`);
        else if (!filter.states.includes(state as JobState)) filter.states.push(state as JobState);
    } else if (filter[word] !== "" && filter[word] !== value) {
      faults.push(`${word}: can be given once`);
    } else if (word === "role" && !kRoles.includes(value)) {
      faults.push(`“${value}” is none of ${kRoles.join(", ")}`);
    } else {
      filter[word] = value;
    }
  }
  return { filter, faults };
}

export function filterText(filter: Filter): string {
  const words = (Object.keys(kWords) as Word[]).map((word) => {
    const value = word === "state" ? filter.states.join(",") : filter[word];
    return value ? `${word}:${quoted(value)}` : "";
  });
  return [...filter.ids, ...words].filter(Boolean).join(" ");
}

/** As the address has it: the names of the daemon's own query, so that links are easily written. */
export function filterOfQuery(query: Record<string, string>): Filter {
  const list = (text: string | undefined) => (text ? text.split(",").filter(Boolean) : []);
  return {
    states: list(query.state).filter((state): state is JobState => kJobStates.includes(state as JobState)),
    method: query.method ?? "",
    scene: query.scene ?? "",
    device: query.device ?? "",
    label: query.label ?? "",
    role: query.role ?? "",
    ids: list(query.id).filter(isId),
  };
}

export const queryOfFilter = (filter: Filter): Record<string, string | null> => ({
  id: filter.ids.join(",") || null,
  ...daemonQuery(filter),
});

/** What the daemon is asked for; `ids` it does not know as a filter. */
export const daemonQuery = (filter: Filter): Record<string, string | null> => ({
  state: filter.states.join(",") || null,
  method: filter.method || null,
  scene: filter.scene || null,
  device: filter.device || null,
  label: filter.label || null,
  role: filter.role || null,
});

/** Whether a job asked for by name is to be shown beside the filter's other words. */
export function matches(filter: Filter, job: JobSummary): boolean {
  const [key, value] = filter.label.split(/=(.*)/s);
  return (
    (filter.states.length === 0 || filter.states.includes(job.state)) &&
    (!filter.method || filter.method === job.method) &&
    (!filter.scene || filter.scene === job.scene) &&
    (!filter.device || filter.device === job.device) &&
    (!filter.role || filter.role === job.role) &&
    (!key || (key in job.labels && (value === undefined || job.labels[key] === value)))
  );
}

// -- suggestions -------------------------------------------------------------------------------------------------------

/** What is known to fill in. */
export interface Vocabulary {
  methods: string[];
  scenes: string[];
  devices: string[];
  labels: string[];
}

export interface Suggestion {
  /** The whole text with the suggestion in it, and where the caret then is. */
  text: string;
  caret: number;
  shown: string;
  hint: string;
}

const kMostSuggestions = 12;

/** What the word at the caret may become: the names of filters, then their values. */
export function suggestionsFor(text: string, caret: number, known: Vocabulary): Suggestion[] {
  const token = tokensOf(text).find(({ start, end }) => start <= caret && caret <= end) ?? { text: "", start: caret, end: caret };
  const typed = text.slice(token.start, caret).toLowerCase();
  const become = (word: string, hint: string, open: boolean): Suggestion => {
    const before = text.slice(0, token.start) + word + (open ? "" : " ");
    const after = text.slice(token.end).trimStart();
    return { text: before + (open && after ? " " : "") + after, caret: before.length, shown: word, hint };
  };
  const values: Record<Word, string[]> = {
    state: [...kJobStates],
    method: known.methods,
    scene: known.scenes,
    device: known.devices,
    label: known.labels,
    role: kRoles,
  };
  const colon = typed.indexOf(":");
  const word = typed.slice(0, Math.max(0, colon));
  if (isWord(word)) {
    // Where states are listed with commas, the last one is being typed.
    const given = unquoted(typed.slice(colon + 1));
    const comma = word === "state" ? given.lastIndexOf(",") + 1 : 0;
    const [kept, begun] = [given.slice(0, comma), given.slice(comma)];
    return values[word]
      .filter((value) => value.toLowerCase().includes(begun) && value.toLowerCase() !== begun)
      .sort((a, b) => Number(b.toLowerCase().startsWith(begun)) - Number(a.toLowerCase().startsWith(begun)))
      .slice(0, kMostSuggestions)
      .map((value) => become(`${word}:${quoted(kept + value)}`, "", false));
  }
  const names = (Object.keys(kWords) as Word[]).filter((name) => name.startsWith(typed)).map((name) => become(`${name}:`, kWords[name], true));
  // A bare word that is a value of some filter.
  const direct = typed
    ? (Object.keys(values) as Word[]).flatMap((name) =>
        values[name].filter((value) => value.toLowerCase().startsWith(typed)).map((value) => become(`${name}:${quoted(value)}`, "", false)),
      )
    : [];
  return [...names, ...direct].slice(0, kMostSuggestions);
}
