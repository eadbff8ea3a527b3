// Where the filter is typed, with suggestions, and the states as buttons with how many jobs are in each.

import { useRef, useState } from "preact/hooks";

import { kJobStates, type JobState } from "../api/types";
import { countText } from "../ui/format";
import { filterText, parseFilter, suggestionsFor, type Filter, type Suggestion, type Vocabulary } from "./filter";

interface Props {
  filter: Filter;
  vocabulary: Vocabulary;
  counts: Partial<Record<JobState, number>>;
  onFilter: (filter: Filter) => void;
  input: { current: HTMLInputElement | null };
  /** Down to the list. */
  onLeave: () => void;
}

const kListId = "jobs-filter-suggestions";

export function FilterBar({ filter, vocabulary, counts, onFilter, input, onLeave }: Props) {
  const held = filterText(filter);
  const [text, setText] = useState<string | null>(null); // null: as the filter has it
  const [suggestions, setSuggestions] = useState<Suggestion[]>([]);
  const [chosen, setChosen] = useState(-1);
  const timer = useRef(0);
  const shown = text ?? held;
  // A word that may still become something is no fault yet.
  const faults = text === null || suggestions.length > 0 ? [] : parseFilter(text).faults;

  const close = () => {
    setSuggestions([]);
    setChosen(-1);
  };
  const apply = (typed: string) => {
    clearTimeout(timer.current);
    onFilter(parseFilter(typed).filter);
  };
  const suggest = () => {
    const element = input.current!;
    setSuggestions(suggestionsFor(element.value, element.selectionStart ?? element.value.length, vocabulary));
    setChosen(-1);
  };
  const take = (suggestion: Suggestion) => {
    // At once, and not when it is drawn: who types on may be faster.
    const element = input.current!;
    element.value = suggestion.text;
    element.focus();
    element.setSelectionRange(suggestion.caret, suggestion.caret);
    setText(suggestion.text);
    apply(suggestion.text);
    if (suggestion.shown.endsWith(":")) suggest();
    else close();
  };
  const onKey = (event: KeyboardEvent) => {
    const open = suggestions.length > 0;
    switch (event.key) {
      case "ArrowDown":
      case "ArrowUp": {
        if (!open) {
          if (event.key === "ArrowDown") onLeave();
          break;
        }
        const step = event.key === "ArrowDown" ? 1 : -1;
        setChosen((chosen + step + suggestions.length + (chosen < 0 && step < 0 ? 1 : 0)) % suggestions.length);
        break;
      }
      case "Enter":
        if (open && chosen >= 0) return take(suggestions[chosen]!), event.preventDefault();
        apply(shown);
        close();
        onLeave();
        break;
      case "Tab":
        if (!open || chosen < 0) return close();
        take(suggestions[chosen]!);
        break;
      case "Escape":
        if (open) close();
        else onLeave();
        break;
      default:
        return;
    }
    event.preventDefault();
  };
  const toggle = (state: JobState) => {
    setText(null);
    const states = filter.states.includes(state) ? filter.states.filter((other) => other !== state) : [...filter.states, state];
    onFilter({ ...filter, states });
  };

  return (
    <search class="jobs-filter">
      <div class="jobs-filter-box">
        <label class="visually-hidden" for="jobs-filter">
          Filter jobs
        </label>
        <input
          id="jobs-filter"
          ref={input}
          type="text"
          role="combobox"
          autocomplete="off"
          spellcheck={false}
          placeholder="Filter: state:failed method:path_tracing scene:cornell-box label:study=x J12"
          value={shown}
          aria-expanded={suggestions.length > 0}
          aria-controls={kListId}
          aria-autocomplete="list"
          aria-activedescendant={chosen >= 0 ? `${kListId}-${chosen}` : undefined}
          aria-describedby="jobs-filter-faults"
          aria-invalid={faults.length > 0 ? "true" : undefined}
          onInput={(event) => {
            const typed = event.currentTarget.value;
            setText(typed);
            suggest();
            clearTimeout(timer.current);
            timer.current = window.setTimeout(() => apply(typed), 250);
          }}
          onFocus={suggest}
          onClick={suggest}
          onBlur={() => {
            close();
            if (parseFilter(shown).faults.length === 0) setText(null);
          }}
          onKeyDown={onKey}
        />
        {shown && (
          <button
            class="quiet jobs-filter-clear"
            aria-label="Clear the filter"
            onClick={() => {
              setText(null);
              apply("");
              input.current!.focus();
            }}
          >
            ✕
          </button>
        )}
        <ul id={kListId} role="listbox" aria-label="Suggestions" class="jobs-suggestions" hidden={suggestions.length === 0}>
          {suggestions.map((suggestion, index) => (
            <li
              key={suggestion.shown}
              id={`${kListId}-${index}`}
              role="option"
              aria-selected={index === chosen}
              onMouseDown={(event) => {
                event.preventDefault(); // which would take the focus away
                take(suggestion);
              }}
            >
              <code>{suggestion.shown}</code>
              <span class="hint">{suggestion.hint}</span>
            </li>
          ))}
        </ul>
        <div id="jobs-filter-faults" class="fault" role="status">
          {faults.map((fault) => (
            <div key={fault}>{fault}</div>
          ))}
        </div>
      </div>
      <div class="jobs-chips" role="group" aria-label="States">
        {kJobStates.map((state) => (
          <button key={state} aria-pressed={filter.states.includes(state)} onClick={() => toggle(state)}>
            {state} <span class="jobs-chip-count">{counts[state] === undefined ? "…" : countText(counts[state])}</span>
          </button>
        ))}
      </div>
    </search>
  );
}
