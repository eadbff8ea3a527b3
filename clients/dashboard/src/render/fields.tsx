// Fields of the form with their faults, each at the place the daemon points to.

import type { ComponentChildren } from "preact";
import { useState } from "preact/hooks";

import type { Fault } from "../api/types";
import { typedText, valueOfText } from "../ui/parameter_form";
import { faultsBelow } from "./draft";

export function FaultLines({ faults, id }: { faults: Fault[]; id?: string }) {
  if (faults.length === 0) return null;
  return (
    <span id={id} class="fault" role="alert">
      {faults.map((fault) => (
        <span key={fault.pointer + fault.detail}>
          {fault.detail}
          <br />
        </span>
      ))}
    </span>
  );
}

interface FieldProps {
  label: string;
  id: string;
  /** Where in the request, as faults name it. */
  pointer: string;
  faults: Fault[];
  hint?: string;
  children: (aria: { id: string; "aria-invalid": "true" | undefined; "aria-describedby": string }) => ComponentChildren;
}

export function Labelled({ label, id, pointer, faults, hint, children }: FieldProps) {
  const own = faultsBelow(faults, pointer);
  return (
    <div class="field" data-pointer={pointer}>
      <label for={id}>{label}</label>
      {children({ id, "aria-invalid": own.length > 0 ? "true" : undefined, "aria-describedby": `${id}-about` })}
      <span id={`${id}-about`} class="hint">
        <FaultLines faults={own} />
        {hint}
      </span>
    </div>
  );
}

interface NumberProps extends Omit<FieldProps, "children"> {
  value: unknown;
  unit?: string;
  placeholder?: string;
  /** Null: nothing is said. What is no number comes as it was typed, for the daemon to name. */
  onValue: (value: unknown) => void;
}

export function NumberField({ value, unit, placeholder, onValue, ...field }: NumberProps) {
  const [typed, setTyped] = useState<string | null>(null);
  const held = typeof value === "number" ? typedText(value) : value ? String(value) : "";
  return (
    <Labelled {...field}>
      {(aria) => (
        <span class="with-unit">
          <input
            {...aria}
            type="text"
            inputMode="decimal"
            autocomplete="off"
            placeholder={placeholder}
            value={typed ?? held}
            onInput={(event) => {
              setTyped(event.currentTarget.value);
              onValue(valueOfText(event.currentTarget.value) ?? null);
            }}
            onBlur={() => setTyped(null)}
          />
          {unit && <span>{unit}</span>}
        </span>
      )}
    </Labelled>
  );
}

export function TextField({ value, placeholder, onValue, ...field }: Omit<FieldProps, "children"> & { value: string; placeholder?: string; onValue: (value: string) => void }) {
  return (
    <Labelled {...field}>
      {(aria) => (
        <input {...aria} type="text" autocomplete="off" spellcheck={false} value={value} placeholder={placeholder} onInput={(event) => onValue(event.currentTarget.value)} />
      )}
    </Labelled>
  );
}

/** Words to tick, such as layers. */
export function Ticks({ legend, words, chosen, onChosen, faults, hint }: { legend: string; words: string[]; chosen: string[]; onChosen: (chosen: string[]) => void; faults: Fault[]; hint?: string }) {
  return (
    <fieldset class="render-ticks">
      <legend>{legend}</legend>
      {[...new Set([...words, ...chosen])].map((word) => (
        <label key={word} class="row">
          <input
            type="checkbox"
            checked={chosen.includes(word)}
            onChange={(event) => onChosen(event.currentTarget.checked ? [...chosen, word] : chosen.filter((other) => other !== word))}
          />
          {word.replaceAll("_", " ")}
        </label>
      ))}
      <span class="hint">
        <FaultLines faults={faults} />
        {hint}
      </span>
    </fieldset>
  );
}
