// When a render ends: passes, seconds, an error, or whichever of them comes first.

import { useState } from "preact/hooks";

import type { Fault, StopConditions } from "../api/types";
import { plainName } from "./format";
import { typedText, valueOfText } from "./parameter_form";

interface Props {
  value: StopConditions;
  onChange: (stop: StopConditions) => void;
  /** Metrics a target may name. */
  metrics: string[];
  /** Pointers as the daemon gives them: "/stop/passes". */
  faults: Fault[];
  idPrefix: string;
  pointer?: string;
}

/** A number that may be left out; what is no number is kept as it was typed, for the daemon to name. */
function Amount({ id, value, unit, faults, onValue }: { id: string; value: unknown; unit: string; faults: Fault[]; onValue: (value: number | null) => void }) {
  const [text, setText] = useState<string | null>(null);
  const held = typeof value === "number" ? typedText(value) : value ? String(value) : "";
  return (
    <>
      <span class="with-unit">
        <input
          id={id}
          type="text"
          inputMode="decimal"
          autocomplete="off"
          placeholder="no limit"
          value={text ?? held}
          aria-invalid={faults.length > 0 ? "true" : undefined}
          aria-describedby={faults.length > 0 ? `${id}-fault` : undefined}
          onInput={(event) => {
            setText(event.currentTarget.value);
            onValue((valueOfText(event.currentTarget.value) ?? null) as number | null);
          }}
          onBlur={() => setText(null)}
        />
        <span>{unit}</span>
      </span>
      {faults.length > 0 && (
        <span id={`${id}-fault`} class="fault" role="alert">
          {faults.map((fault) => fault.detail).join("; ")}
        </span>
      )}
    </>
  );
}

export function StopFields({ value, onChange, metrics, faults, idPrefix, pointer = "/stop" }: Props) {
  const at = (name: string) => faults.filter((fault) => fault.pointer === `${pointer}${name}`);
  const set = (name: "passes" | "seconds", amount: number | null) => {
    const { [name]: _, ...rest } = value;
    onChange(amount === null ? rest : { ...rest, [name]: amount });
  };
  const { target } = value;
  const metric = target?.metric ?? metrics[0] ?? "estimated_relative_mse";
  const setTarget = (next: StopConditions["target"]) => {
    const { target: _, ...rest } = value;
    onChange(next ? { ...rest, target: next } : rest);
  };
  const targetFaults = [...at("/target"), ...at("/target/metric"), ...at("/target/value")];
  return (
    <>
      <div class="fields">
        <div class="field">
          <label for={`${idPrefix}-passes`}>After</label>
          <Amount id={`${idPrefix}-passes`} value={value.passes} unit="passes" faults={at("/passes")} onValue={(passes) => set("passes", passes)} />
        </div>
        <div class="field">
          <label for={`${idPrefix}-seconds`}>or after</label>
          <Amount id={`${idPrefix}-seconds`} value={value.seconds} unit="s" faults={at("/seconds")} onValue={(seconds) => set("seconds", seconds)} />
        </div>
        <div class="field">
          <label for={`${idPrefix}-target`}>or at an error of at most</label>
          <Amount id={`${idPrefix}-target`} value={target?.value} unit="" faults={targetFaults} onValue={(amount) => setTarget(amount === null ? null : { metric, value: amount })} />
        </div>
        <div class="field">
          <label for={`${idPrefix}-metric`}>by the metric</label>
          <select
            id={`${idPrefix}-metric`}
            value={metric}
            disabled={!target}
            aria-invalid={at("/target/metric").length > 0 ? "true" : undefined}
            onChange={(event) => target && setTarget({ ...target, metric: event.currentTarget.value })}
          >
            {[...new Set([...metrics, metric])].map((name) => (
              <option key={name} value={name}>
                {plainName(name)}
              </option>
            ))}
          </select>
        </div>
      </div>
      {at("").map((fault) => (
        <p key={fault.detail} class="fault" role="alert">
          {fault.detail}
        </p>
      ))}
    </>
  );
}
