// A method, the device it runs on and its parameters, as a form made from what the daemon says of its methods.

import "./method_form.css";

import { useEffect, useRef, useState } from "preact/hooks";

import type { Device, Fault, Json, Method, MethodChoice, Parameters } from "../api/types";
import {
  choiceOf,
  defaultText,
  devicesOf,
  faultOf,
  fieldsOf,
  groupsOf,
  isDefault,
  lineOn,
  rangeText,
  typedText,
  valueOfText,
  withParameter,
  type Field,
  type Group,
} from "./parameter_form";
import { plainName } from "./format";

interface Props {
  methods: Method[];
  devices: Device[];
  value: MethodChoice;
  onChange: (choice: MethodChoice) => void;
  /** The daemon's, pointers relative to the method: "/parameters/photons". */
  faults?: Fault[];
  /** Of the controls' ids, where a page has more than one such form. */
  idPrefix: string;
}

const textOf = (field: Field, value: Json | undefined): string =>
  isDefault(field, value) || value === null ? "" : typeof value === "number" ? typedText(value) : String(value);

/** Keeps what is typed as it is typed ("1e", "0."), for as long as it means the value that is held. */
function NumberInput({ field, value, id, fault, describedBy, onValue }: ControlProps) {
  const [text, setText] = useState(() => textOf(field, value));
  const meant = valueOfText(text);
  useEffect(() => {
    if (meant !== value && !(isDefault(field, meant) && isDefault(field, value))) setText(textOf(field, value));
  }, [value]);
  const unit = field.schema["x-unit"];
  return (
    <span class="with-unit">
      <input
        id={id}
        type="text"
        inputMode={field.type === "integer" ? "numeric" : "decimal"}
        autocomplete="off"
        value={text}
        placeholder={defaultText(field)}
        aria-invalid={fault ? "true" : undefined}
        aria-describedby={describedBy}
        onInput={(event) => {
          setText(event.currentTarget.value);
          onValue(valueOfText(event.currentTarget.value));
        }}
      />
      {unit && <span>{unit}</span>}
    </span>
  );
}

interface ControlProps {
  field: Field;
  value: Json | undefined;
  id: string;
  fault: string | null;
  describedBy: string;
  onValue: (value: Json | undefined) => void;
}

function Control(props: ControlProps) {
  const { field, value, id, fault, describedBy, onValue } = props;
  const now = value === undefined ? (field.schema.default ?? null) : value;
  if (field.type === "boolean")
    return (
      <span class="with-unit">
        <input
          id={id}
          type="checkbox"
          checked={now === true}
          aria-describedby={describedBy}
          onChange={(event) => onValue(event.currentTarget.checked)}
        />
        <span aria-hidden="true">{now === true ? "yes" : "no"}</span>
      </span>
    );
  if (field.schema.enum)
    return (
      <select
        id={id}
        value={String(now)}
        aria-invalid={fault ? "true" : undefined}
        aria-describedby={describedBy}
        onChange={(event) => onValue(event.currentTarget.value)}
      >
        {/* What a hand-written request says is shown too, with its fault, rather than quietly replaced. */}
        {!field.schema.enum.includes(String(now)) && <option value={String(now)}>{String(now)}</option>}
        {field.schema.enum.map((word) => (
          <option key={word} value={word}>
            {plainName(word)}
            {word === field.schema.default ? " (default)" : ""}
          </option>
        ))}
      </select>
    );
  return <NumberInput {...props} />;
}

interface FieldProps {
  field: Field;
  value: Json | undefined;
  id: string;
  faults: string[];
  onValue: (value: Json | undefined) => void;
}

function ParameterField({ field, value, id, faults, onValue }: FieldProps) {
  const changed = !isDefault(field, value);
  const found = value === undefined ? null : faultOf(field, value);
  // The daemon's own word comes a moment later than ours, and says the same.
  const said = found ? [found] : faults;
  const range = rangeText(field);
  return (
    <div class={changed ? "method-form-field changed" : "method-form-field"}>
      <span class="method-form-label">
        <label for={id}>{plainName(field.name)}</label>
        {changed && (
          <button type="button" class="quiet" title={`Back to ${defaultText(field)}`} onClick={() => onValue(undefined)}>
            Reset<span class="visually-hidden"> {plainName(field.name)}</span>
          </button>
        )}
      </span>
      <Control field={field} value={value} id={id} fault={said[0] ?? null} describedBy={`${id}-hint`} onValue={onValue} />
      <span id={`${id}-hint`} class="hint">
        {said.map((fault) => (
          <span key={fault} class="fault" role="alert">
            {fault}
            <br />
          </span>
        ))}
        {field.schema.description}
        {range && (
          <>
            {field.schema.description ? " · " : ""}
            {range}
          </>
        )}
        {changed && field.type !== "string" && ` · default ${defaultText(field)}`}
      </span>
    </div>
  );
}

interface GroupProps {
  group: Group;
  parameters: Parameters;
  idPrefix: string;
  faults: Fault[];
  onParameters: (parameters: Parameters) => void;
}

function Fields({ group, parameters, idPrefix, faults, onParameters }: GroupProps) {
  return (
    <div class="method-form-fields">
      {group.fields.map((field) => (
        <ParameterField
          key={field.name}
          field={field}
          value={parameters[field.name]}
          id={`${idPrefix}-${field.name}`}
          faults={faults
            .filter((fault) => fault.pointer === `/parameters/${field.name}`)
            .map((fault) => fault.detail.replace(`${field.name}: `, ""))}
          onValue={(value) => onParameters(withParameter(parameters, field, value))}
        />
      ))}
    </div>
  );
}

/** A group that is closed until it is wanted, or until something in it is wrong. */
function FoldedGroup(props: GroupProps) {
  const { group, parameters, faults } = props;
  const names = group.fields.map((field) => field.name);
  const changed = group.fields.filter((field) => !isDefault(field, parameters[field.name])).length;
  const wrong = faults.some((fault) => names.includes(fault.pointer.split("/")[2] ?? ""));
  const details = useRef<HTMLDetailsElement>(null);
  useEffect(() => {
    if (wrong) details.current!.open = true;
  }, [wrong]);
  return (
    <details ref={details} class="method-form-group">
      <summary>
        {group.title}
        <span class="hint">{group.fields.length === 1 ? "1 setting" : `${group.fields.length} settings`}</span>
        {changed > 0 && <span class="method-form-count">{changed} changed</span>}
      </summary>
      <Fields {...props} />
    </details>
  );
}

export function MethodForm({ methods, devices, value, onChange, faults = [], idPrefix }: Props) {
  // Coming back to a method one looked away from, its parameters are as they were left.
  const left = useRef(new Map<string, Parameters>());
  const method = methods.find((other) => other.name === value.name);
  const parameters = value.parameters ?? {};
  const families = [...new Set(methods.map((other) => other.family))];
  const at = (pointer: string) => faults.filter((fault) => fault.pointer === pointer);

  const choose = (name: string) => {
    left.current.set(value.name, parameters);
    const chosen = methods.find((other) => other.name === name)!;
    onChange(choiceOf(chosen, devices, value.device, left.current.get(name) ?? {}));
  };
  const fields = method ? fieldsOf(method) : [];
  const known = new Set(fields.map((field) => field.name));
  const strangers = Object.keys(parameters).filter((name) => method && !known.has(name));
  const changed = fields.filter((field) => !isDefault(field, parameters[field.name])).length;
  const possible = method ? devicesOf(method, devices) : [];
  const device = value.device ?? "cpu";
  const deviceKnown = possible.some((other) => other.id === device);
  const elsewhere = faults.filter(
    (fault) => !/^\/(name|device)$/.test(fault.pointer) && !known.has(/^\/parameters\/([^/]+)/.exec(fault.pointer)?.[1] ?? ""),
  );
  return (
    <div class="method-form">
      <div class="method-form-choice">
        <div class="field">
          <label for={`${idPrefix}-method`}>Method</label>
          <select
            id={`${idPrefix}-method`}
            value={value.name}
            aria-describedby={`${idPrefix}-method-line`}
            aria-invalid={at("/name").length > 0 ? "true" : undefined}
            onChange={(event) => choose(event.currentTarget.value)}
          >
            {!method && <option value={value.name}>{value.name || "Choose a method"}</option>}
            {families.map((family) => (
              <optgroup key={family} label={family[0]!.toUpperCase() + family.slice(1)}>
                {methods
                  .filter((other) => other.family === family)
                  .map((other) => {
                    const runs = devicesOf(other, devices).length > 0;
                    return (
                      <option key={other.name} value={other.name} disabled={!runs && other.name !== value.name}>
                        {other.title}
                        {runs ? "" : ` (needs a ${other.devices.join(" or ")})`}
                      </option>
                    );
                  })}
              </optgroup>
            ))}
          </select>
          <span id={`${idPrefix}-method-line`} class="hint">
            {at("/name").map((fault) => (
              <span key={fault.detail} class="fault" role="alert">
                {fault.detail}
                <br />
              </span>
            ))}
            {method && lineOn(method)}
          </span>
        </div>
        <div class="field">
          <label for={`${idPrefix}-device`}>Device</label>
          <select
            id={`${idPrefix}-device`}
            value={device}
            aria-describedby={`${idPrefix}-device-line`}
            aria-invalid={at("/device").length > 0 ? "true" : undefined}
            onChange={(event) => onChange({ ...value, device: event.currentTarget.value })}
          >
            {!deviceKnown && <option value={device}>{device === "gpu" ? "gpu, the first there is" : device}</option>}
            {possible.map((other) => (
              <option key={other.id} value={other.id}>
                {other.id} · {other.name}
                {other.state === "failed" ? " (failed)" : ""}
              </option>
            ))}
          </select>
          <span id={`${idPrefix}-device-line`} class="hint">
            {at("/device").map((fault) => (
              <span key={fault.detail} class="fault" role="alert">
                {fault.detail}
              </span>
            ))}
          </span>
        </div>
      </div>
      {elsewhere.map((fault) => (
        <p key={fault.pointer + fault.detail} class="notice failed" role="alert">
          {fault.detail}
        </p>
      ))}
      {method && (
        <>
          <div class="method-form-summary">
            {changed > 0 ? <span class="method-form-count">{changed} changed</span> : "Everything is as by default."}
            {(changed > 0 || strangers.length > 0) && (
              <button type="button" class="quiet" onClick={() => onChange({ ...value, parameters: {} })}>
                Reset all
              </button>
            )}
            {strangers.length > 0 && <span class="fault">unknown to this method: {strangers.join(", ")}</span>}
          </div>
          {groupsOf(method).map((group, index) => {
            const Part = index === 0 ? Fields : FoldedGroup;
            return (
              <Part
                key={`${method.name} ${group.title}`}
                group={group}
                parameters={parameters}
                idPrefix={idPrefix}
                faults={faults}
                onParameters={(next) => onChange({ ...value, parameters: next })}
              />
            );
          })}
        </>
      )}
    </div>
  );
}
