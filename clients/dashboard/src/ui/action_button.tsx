import type { ComponentChildren } from "preact";
import { useEffect, useRef, useState } from "preact/hooks";

import { sayFailure } from "./toasts";

interface Props {
  /** What it does; a failure is said, and it can be pressed again. */
  run: () => Promise<unknown>;
  /** What it says from the press on, until that has failed or what it did shows. */
  busy: string;
  /** What shows that: the button is as before once this is another. */
  until: string;
  class?: string;
  label?: string;
  children: ComponentChildren;
}

/** A button that answers at once, however long the daemon takes. */
export function ActionButton({ run, busy, until, label, children, ...look }: Props) {
  const [pressed, setPressed] = useState(false);
  const shown = useRef(true);
  useEffect(() => () => void (shown.current = false), []);
  useEffect(() => setPressed(false), [until]);
  const press = () => {
    setPressed(true);
    run().catch((failure: unknown) => {
      if (shown.current) setPressed(false);
      sayFailure(failure);
    });
  };
  return (
    <button {...look} disabled={pressed} aria-label={pressed ? undefined : label} onClick={press}>
      {pressed ? busy : children}
    </button>
  );
}
