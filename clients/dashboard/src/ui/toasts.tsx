// Short messages that pass, and failures that stay until they are read.

import { signal } from "@preact/signals";

import { Problem } from "../api/client";

interface Toast {
  id: number;
  text: string;
  faults: string[];
  failed: boolean;
}

const kShownMs = 4000;
const toasts = signal<Toast[]>([]);
let next = 0;

const close = (id: number) => (toasts.value = toasts.value.filter((toast) => toast.id !== id));

function add(text: string, failed: boolean, faults: string[] = []): void {
  const id = ++next;
  toasts.value = [...toasts.value.slice(-4), { id, text, faults, failed }];
  if (!failed) setTimeout(() => close(id), kShownMs);
}

export const say = (text: string): void => add(text, false);

/** Says what went wrong, with every fault the daemon named. */
export function sayFailure(failure: unknown): void {
  if (failure instanceof DOMException && failure.name === "AbortError") return;
  const faults = failure instanceof Problem ? failure.faults.map((fault) => `${fault.pointer}: ${fault.detail}`) : [];
  add(failure instanceof Error ? failure.message : String(failure), true, faults);
}

export function Toasts() {
  return (
    <div class="toasts" role="log" aria-live="polite" aria-label="Messages">
      {toasts.value.map((toast) => (
        <div key={toast.id} class={toast.failed ? "toast failed" : "toast"} role={toast.failed ? "alert" : undefined}>
          <div>
            {toast.text}
            {toast.faults.length > 0 && (
              <ul>
                {toast.faults.map((fault) => (
                  <li key={fault}>{fault}</li>
                ))}
              </ul>
            )}
          </div>
          <button class="quiet" aria-label="Dismiss" onClick={() => close(toast.id)}>
            ✕
          </button>
        </div>
      ))}
    </div>
  );
}
