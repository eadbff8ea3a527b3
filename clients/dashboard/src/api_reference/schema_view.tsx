// A schema as a table of its members; those of objects within open below them.

import type { ComponentChildren } from "preact";
import { useState } from "preact/hooks";

import { nameOfRef, type OpenApi, resolved, type Schema, typeText, withoutNull } from "./openapi_document";

/** Objects within objects are shown so deep; deeper ones by their name alone. */
const kDeepest = 6;

/** The schemas with members of their own in this one: itself, the items of a list, or choices. */
function shapesIn(document: OpenApi, schema: Schema): { name: string | null; shape: Schema }[] {
  const { schema: own } = withoutNull(schema);
  const whole = resolved(document, own);
  const name = own.$ref ? nameOfRef(own.$ref) : null;
  if (whole.properties) return [{ name, shape: whole }];
  if (whole.items) return shapesIn(document, whole.items);
  const choices = whole.anyOf ?? whole.oneOf;
  if (choices) return choices.flatMap((choice) => shapesIn(document, choice));
  if (typeof whole.additionalProperties === "object") return shapesIn(document, whole.additionalProperties);
  return [];
}

/**
 * What is there from the first time that it is opened: all that a job may be is ten thousand elements, of which one looks
 * at few.
 */
export function Unfolded({ summary, class: className, children }: { summary: ComponentChildren; class?: string; children: () => ComponentChildren }) {
  const [seen, setSeen] = useState(false);
  return (
    <details class={className} onToggle={(event) => event.currentTarget.open && setSeen(true)}>
      {summary}
      {seen && children()}
    </details>
  );
}

function Member({ document, name, schema, required, depth }: { document: OpenApi; name: string; schema: Schema; required: boolean; depth: number }) {
  const inner = depth < kDeepest ? shapesIn(document, schema) : [];
  const { schema: own } = withoutNull(schema);
  const text = own.description ?? resolved(document, own).description;
  return (
    <li>
      <code>{name}</code> {required && <strong class="api-required">required</strong>} <span class="muted small">{typeText(schema)}</span>
      {own.default !== undefined && <span class="muted small">, default {JSON.stringify(own.default)}</span>}
      {text && <div class="small">{text}</div>}
      {inner.length > 0 && (
        <Unfolded summary={<summary class="small">{inner.map(({ name }) => name ?? "its members").join(", ")}</summary>}>
          {() => <SchemaView document={document} schema={schema} depth={depth + 1} />}
        </Unfolded>
      )}
    </li>
  );
}

export function SchemaView({ document, schema, depth = 0 }: { document: OpenApi; schema: Schema; depth?: number }) {
  const shapes = shapesIn(document, schema);
  if (shapes.length === 0) return <p class="small">{typeText(schema)}</p>;
  return (
    <>
      {shapes.map(({ name, shape }, index) => (
        <div key={name ?? index}>
          {shapes.length > 1 && name && <p class="api-shape">{name}</p>}
          <ul class="api-members">
            {Object.entries(shape.properties!).map(([member, inner]) => (
              <Member key={member} document={document} name={member} schema={inner} required={shape.required?.includes(member) ?? false} depth={depth} />
            ))}
          </ul>
        </div>
      ))}
    </>
  );
}
