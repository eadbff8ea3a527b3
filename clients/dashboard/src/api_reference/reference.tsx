// What can be asked of the daemon by HTTP, made from the document that it publishes about itself.

import "./reference.css";

import { useEffect, useMemo, useState } from "preact/hooks";

import { Title } from "../app/title";
import { useQuery } from "../app/url_state";
import { useRemote } from "../ui/remote";
import { say, sayFailure } from "../ui/toasts";
import { curlOf, groupsOf, isFound, type OpenApi, type Operation, typeText } from "./openapi_document";
import { SchemaView, Unfolded } from "./schema_view";

const kDocument = "/v1/openapi.json";
const anchorOf = ({ operationId }: Operation): string => `op-${operationId}`;

function Parameters({ operation }: { operation: Operation }) {
  const parameters = operation.parameters ?? [];
  if (parameters.length === 0) return null;
  return (
    <section>
      <h3>Parameters</h3>
      <ul class="api-members">
        {parameters.map(({ name, in: place, required, description, schema }) => (
          <li key={`${place} ${name}`}>
            <code>{name}</code> <span class="api-place">{place}</span> {required && <strong class="api-required">required</strong>}{" "}
            <span class="muted small">{typeText(schema)}</span>
            {(description ?? schema.description) && <div class="small">{description ?? schema.description}</div>}
          </li>
        ))}
      </ul>
    </section>
  );
}

function Details({ document, operation }: { document: OpenApi; operation: Operation }) {
  const line = curlOf(document, operation, location.origin);
  const body = Object.entries(operation.requestBody?.content ?? {});
  return (
    <div class="api-details">
      <Parameters operation={operation} />
      {body.length > 0 && (
        <section>
          <h3>Body</h3>
          {body.map(([media, { schema }]) => (
            <div key={media}>
              <p class="small">
                <code>{media}</code>
              </p>
              {schema && media.includes("json") && <SchemaView document={document} schema={schema} />}
            </div>
          ))}
        </section>
      )}
      <section>
        <h3>Answers</h3>
        {Object.entries(operation.responses).map(([status, { description, content }]) => (
          <Unfolded
            key={status}
            class="api-answer"
            summary={
              <summary>
                <code>{status === "default" ? "4xx, 5xx" : status}</code> {description} <span class="muted small">{Object.keys(content ?? {}).join(", ")}</span>
              </summary>
            }
          >
            {() => Object.entries(content ?? {}).map(([media, { schema }]) => schema && media.includes("json") && <SchemaView key={media} document={document} schema={schema} />)}
          </Unfolded>
        ))}
      </section>
      <section>
        <h3>Example</h3>
        <pre class="api-example" tabIndex={0} role="region" aria-label={`Example of ${operation.operationId}`}>
          {line}
        </pre>
        <button class="small" onClick={() => navigator.clipboard.writeText(line).then(() => say("The line is copied."), () => sayFailure(new Error("The browser does not let the page copy.")))}>
          Copy
        </button>
      </section>
    </div>
  );
}

function One({ document, operation, open, onOpen }: { document: OpenApi; operation: Operation; open: boolean; onOpen: (open: boolean) => void }) {
  return (
    <details class="api-operation" id={anchorOf(operation)} open={open} onToggle={(event) => event.currentTarget.open !== open && onOpen(event.currentTarget.open)}>
      <summary>
        <span class={`api-method ${operation.method}`}>{operation.method.toUpperCase()}</span> <code class="api-path">{operation.path}</code>
        <span class="api-summary">{operation.summary}</span>
      </summary>
      {open && <Details document={document} operation={operation} />}
    </details>
  );
}

export function ApiReference() {
  const { data: document, failure, reload } = useRemote<OpenApi>(kDocument);
  const [query, change] = useQuery();
  const words = query.find ?? "";
  const [open, setOpen] = useState<ReadonlySet<string>>(new Set(query.op ? [query.op] : []));
  const groups = useMemo(() => (document ? groupsOf(document) : []), [document]);
  const found = groups.map((group) => ({ ...group, operations: group.operations.filter((operation) => isFound(operation, words)) })).filter(({ operations }) => operations.length > 0);
  const count = found.reduce((sum, { operations }) => sum + operations.length, 0);
  useEffect(() => {
    if (document && query.op) window.document.getElementById(`op-${query.op}`)?.scrollIntoView({ block: "start" });
  }, [document]);
  const toggle = (operation: Operation, now: boolean) => {
    setOpen((before) => {
      const next = new Set(before);
      if (now) next.add(operation.operationId);
      else next.delete(operation.operationId);
      return next;
    });
    change({ op: now ? operation.operationId : null });
  };
  return (
    <>
      <Title text="By HTTP">
        <a class="button" href={kDocument} target="_blank">
          OpenAPI document
        </a>
      </Title>
      {failure && !document && (
        <p class="notice failed" role="alert">
          {failure.message}. <button onClick={reload}>Try again</button>
        </p>
      )}
      {!document && !failure && (
        <p class="muted" role="status">
          Loading …
        </p>
      )}
      {document && (
        <div class="api-room">
          <div class="api-find">
            <input type="search" aria-label="Find operations" placeholder="Find: preview, jobs state, post …" value={words} onInput={(event) => change({ find: event.currentTarget.value })} />
            <p class="small muted" role="status">
              {count === 1 ? "1 operation" : `${count} operations`}
            </p>
            <nav aria-label="Subjects">
              {found.map(({ name, operations }) => (
                <a key={name} href={`#api-${name.replaceAll(" ", "-")}`} onClick={(event) => {
                  event.preventDefault();
                  window.document.getElementById(`api-${name.replaceAll(" ", "-")}`)?.scrollIntoView({ block: "start" });
                }}>
                  {name} <span class="muted">{operations.length}</span>
                </a>
              ))}
            </nav>
          </div>
          <div class="api-all">
            <p>{document.info.description}</p>
            {count === 0 && <p class="empty">Nothing is found by these words.</p>}
            {found.map(({ name, operations }) => (
              <section key={name} class="panel" id={`api-${name.replaceAll(" ", "-")}`} aria-label={name}>
                <h2>{name}</h2>
                {operations.map((operation) => (
                  <One key={operation.operationId} document={document} operation={operation} open={open.has(operation.operationId)} onOpen={(now) => toggle(operation, now)} />
                ))}
              </section>
            ))}
          </div>
        </div>
      )}
    </>
  );
}
