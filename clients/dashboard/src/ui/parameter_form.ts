// What a form of a method's parameters knows, without the form: the fields made from the method's JSON Schema, what they
// take, and which belong together. The daemon checks everything again; faults found here are said in its words.

import type { Device, Fault, Json, Method, MethodChoice, ParameterSchema, ParameterType, Parameters } from "../api/types";

export interface Field {
  name: string;
  schema: ParameterSchema;
  type: ParameterType;
  /** May be left open: null is a value of its own, mostly "worked out from others". */
  optional: boolean;
}

/** A method's parameters in the order they were declared, which is the order to read them in. */
export function fieldsOf(method: Method): Field[] {
  const { properties, "x-order": order } = method.parameters;
  return (order ?? Object.keys(properties)).map((name) => {
    const schema = properties[name]!;
    const types = Array.isArray(schema.type) ? schema.type : [schema.type];
    return { name, schema, type: types.find((type): type is ParameterType => type !== "null")!, optional: types.includes("null") };
  });
}

/** A number as the daemon's messages write it: "0.5", "64", "1e+09". */
export function exactText(value: number): string {
  const plain = String(value);
  const [digits, exponent] = value.toExponential().split("e") as [string, string];
  const padded = `${digits}e${exponent[0]}${exponent.slice(1).padStart(2, "0")}`;
  return plain.includes("e") || padded.length < plain.length ? padded : plain;
}

/** A number as one types it: "200000", but "1e9" rather than a row of noughts. */
export function typedText(value: number): string {
  const plain = String(value);
  return plain.length <= 7 ? plain : exactText(value).replace(/e\+?(-?)0*/, "e$1");
}

const valueText = (value: Json): string =>
  typeof value === "number" && !Number.isInteger(value) ? exactText(value) : JSON.stringify(value);

function unitOf(field: Field): string {
  const unit = field.schema["x-unit"];
  return unit ? ` ${unit}` : "";
}

/** "1 to 1e9 photons" */
export function rangeText({ schema, type }: Field): string {
  if (type !== "number" && type !== "integer") return "";
  if (schema.minimum === undefined || schema.maximum === undefined) return schema["x-unit"] ?? "";
  const unit = schema["x-unit"];
  return `${typedText(schema.minimum)} to ${typedText(schema.maximum)}${unit ? ` ${unit}` : ""}`;
}

/** What a value is when nothing is said: "200000", "not given". */
export function defaultText({ schema }: Field): string {
  const value = schema.default ?? null;
  if (value === null) return "not given";
  if (typeof value === "boolean") return value ? "yes" : "no";
  return typeof value === "number" ? typedText(value) : String(value);
}

/** What the daemon would say of a value, without "NAME: " before it; null where it would take it. */
export function faultOf(field: Field, value: Json): string | null {
  const { schema, type, optional } = field;
  if (value === null && optional) return null;
  switch (type) {
    case "boolean":
      return typeof value === "boolean" ? null : `must be true or false, got ${valueText(value)}`;
    case "string": {
      if (schema.enum && !(typeof value === "string" && schema.enum.includes(value)))
        return `must be one of ${schema.enum.map((word) => `"${word}"`).join(", ")}, got ${valueText(value)}`;
      return typeof value === "string" ? null : `must be a string, got ${valueText(value)}`;
    }
    default: {
      const whole = type === "integer";
      if (typeof value !== "number" || (whole && !Number.isInteger(value)))
        return `must be a ${whole ? "whole " : ""}number, got ${valueText(value)}`;
      const { minimum = -Infinity, maximum = Infinity } = schema;
      if (value >= minimum && value <= maximum) return null;
      return `${valueText(value)} is outside [${exactText(minimum)}, ${exactText(maximum)}]${unitOf(field)}`;
    }
  }
}

/**
 * What was typed, as a value: a number where it is one, the text itself where it is none (so that whoever checks can say
 * what was got), and undefined, which is the default, for nothing.
 */
export function valueOfText(text: string): Json | undefined {
  const trimmed = text.trim();
  if (trimmed === "") return undefined;
  const number = Number(trimmed);
  return Number.isFinite(number) && !/^[+-]?0[xob]/i.test(trimmed) ? number : trimmed;
}

export const isDefault = (field: Field, value: Json | undefined): boolean => value === undefined || value === (field.schema.default ?? null);

/** The parameters with one changed. What is as by default is left out, so that a request says what is meant by it. */
export function withParameter(parameters: Parameters, field: Field, value: Json | undefined): Parameters {
  const { [field.name]: _, ...rest } = parameters;
  return isDefault(field, value) ? rest : { ...rest, [field.name]: value as Json };
}

/** Parameters, such as a job's echo of its request, without those that are as by default. */
export function changedParameters(method: Method, parameters: Parameters | undefined): Parameters {
  const fields = new Map(fieldsOf(method).map((field) => [field.name, field]));
  const known = ([name, value]: [string, Json]) => !fields.has(name) || !isDefault(fields.get(name)!, value);
  return Object.fromEntries(Object.entries(parameters ?? {}).filter(known));
}

/** All faults of a choice of method that can be told without the daemon, pointers relative to the choice. */
export function localFaults(method: Method, choice: MethodChoice): Fault[] {
  const fields = new Map(fieldsOf(method).map((field) => [field.name, field]));
  return Object.entries(choice.parameters ?? {}).flatMap(([name, value]) => {
    const field = fields.get(name);
    const fault = field ? faultOf(field, value) : "unknown parameter";
    return fault ? [{ pointer: `/parameters/${name}`, detail: `${name}: ${fault}` }] : [];
  });
}

// -- which parameters belong together ----------------------------------------------------------------------------------

export interface Group {
  title: string;
  fields: Field[];
}

const kOther = "Other";

/** The fields in groups, none of them empty, in the daemon's order: the first is what one changes first. */
export function groupsOf(method: Method): Group[] {
  const groups = new Map<string, Field[]>((method.parameters["x-groups"] ?? []).map((title) => [title, []]));
  for (const field of fieldsOf(method)) {
    const title = field.schema["x-group"] ?? kOther;
    groups.set(title, [...(groups.get(title) ?? []), field]);
  }
  return [...groups].filter(([, fields]) => fields.length > 0).map(([title, fields]) => ({ title, fields }));
}

// -- methods and devices -----------------------------------------------------------------------------------------------

/** One line on a method for who does not know it. */
export const lineOn = (method: Method): string => method.line ?? method.sources[0] ?? method.family;

/** The devices of this daemon that a method runs on. */
export const devicesOf = (method: Method, devices: Device[]): Device[] =>
  devices.filter((device) => device.served !== false && method.devices.includes(device.kind));

/** A choice of a method on the device chosen before, where it runs there. */
export function choiceOf(method: Method, devices: Device[], device: string | undefined, parameters: Parameters = {}): MethodChoice {
  const possible = devicesOf(method, devices);
  const same = possible.find((other) => other.id === device || other.kind === device);
  return { name: method.name, device: same ? device! : (possible[0]?.id ?? method.devices[0] ?? "cpu"), parameters };
}
