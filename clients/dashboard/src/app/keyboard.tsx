// Keys: a room says which it has while it is shown, and "?" lists all that work now.

import { signal } from "@preact/signals";
import { useLayoutEffect } from "preact/hooks";

import { Dialog } from "../ui/dialog";

export interface Key {
  /** As KeyboardEvent.key has it: "j", "ArrowDown", "1"; "Shift+ArrowUp" where the key's name does not show it; "g j" is one after the other. */
  key: string;
  /** What pressing it does, for the list; keys of the same text are listed together. */
  text: string;
  run: (event: KeyboardEvent) => void;
}

const active = signal<{ title: string; keys: Key[] }[]>([]);
const helpShown = signal(false);

/** The keys of a room while it is shown. `deps` as for useEffect. */
export function useKeys(title: string, keys: Key[], deps: unknown[]): void {
  // With the drawing and not after it: the next key may be pressed before that, and is meant for what it will show.
  useLayoutEffect(() => {
    const group = { title, keys };
    active.value = [...active.peek(), group];
    return () => {
      active.value = active.peek().filter((other) => other !== group);
    };
  }, deps);
}

const isTyping = (target: EventTarget | null) =>
  target instanceof HTMLElement && (target.isContentEditable || /^(INPUT|SELECT|TEXTAREA)$/.test(target.tagName) && !/^(checkbox|radio|button|range)$/.test((target as HTMLInputElement).type));

/** Keys that the control which has the focus answers to itself: Enter presses a button, arrows move a slider. */
function isItsOwn(event: KeyboardEvent): boolean {
  if (!(event.target instanceof Element)) return false;
  if (event.key === "Enter" || event.key === " ") return event.target.closest("button, a[href], summary, input, [role=button]") !== null;
  return /^(Arrow|Home|End|Page)/.test(event.key) && event.target.closest("input, [role=slider], [role=tablist], [role=listbox]") !== null;
}

function nameOf(event: KeyboardEvent): string {
  const special = event.shiftKey && event.key.length > 1 ? "Shift+" : "";
  return special + event.key;
}

const kSequenceMs = 1500;
let first = { key: "", at: 0 };

function onKey(event: KeyboardEvent): void {
  if (event.defaultPrevented || event.ctrlKey || event.metaKey || event.altKey || isTyping(event.target) || isItsOwn(event)) return;
  if (document.querySelector("dialog[open]") && event.key !== "?") return;
  if (event.key === "?") {
    helpShown.value = !helpShown.value;
    event.preventDefault();
    return;
  }
  const name = nameOf(event);
  const sequence = event.timeStamp - first.at < kSequenceMs ? `${first.key} ${name}` : name;
  first = { key: name, at: event.timeStamp };
  for (const wanted of sequence === name ? [name] : [sequence, name])
    for (const group of [...active.value].reverse()) {
      const found = group.keys.find((key) => key.key === wanted);
      if (!found) continue;
      found.run(event);
      event.preventDefault();
      return;
    }
}

export const showKeys = () => (helpShown.value = true);

/** Listens for keys, and holds the list of them. Once, in the shell. */
export function Keyboard() {
  useLayoutEffect(() => {
    document.addEventListener("keydown", onKey);
    return () => document.removeEventListener("keydown", onKey);
  }, []);
  if (!helpShown.value) return null;
  return (
    <Dialog title="Keys" onClose={() => (helpShown.value = false)}>
      {active.value.map((group) => (
        <section key={group.title} class="key-group">
          <h3>{group.title}</h3>
          <dl>
            {[...new Set(group.keys.map((key) => key.text))].map((text) => (
              <div key={text}>
                <dt>
                  {group.keys
                    .filter((key) => key.text === text)
                    .map((key) => (
                      <kbd key={key.key}>{key.key === " " ? "Space" : key.key}</kbd>
                    ))}
                </dt>
                <dd>{text}</dd>
              </div>
            ))}
          </dl>
        </section>
      ))}
    </Dialog>
  );
}
