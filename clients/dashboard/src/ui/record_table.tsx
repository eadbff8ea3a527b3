// A list of what there is, newest first: a table, and cards where there is no width for its columns.

import "./record_table.css";

import type { ComponentChildren } from "preact";

/** What a column says of a thing, by which a card has a place for it: its id, what it is, how it stands, when, or a figure. */
export type RecordPart = "id" | "what" | "state" | "when" | "figure";

export interface RecordColumn {
  title: string;
  part: RecordPart;
  number?: boolean;
}

interface Props {
  label: string;
  columns: RecordColumn[];
  /** As many cells as there are columns. */
  rows: { id: string; cells: ComponentChildren[] }[];
}

export function RecordTable({ label, columns, rows }: Props) {
  const classOf = ({ part, number }: RecordColumn) => `records-${part}${number ? " number" : ""}`;
  return (
    <div class="scroll-x" tabIndex={0} role="group" aria-label={label}>
      <table class="records">
        <thead>
          <tr>
            {columns.map((column) => (
              <th key={column.title} scope="col" class={classOf(column)}>
                {column.title}
              </th>
            ))}
          </tr>
        </thead>
        <tbody>
          {rows.map(({ id, cells }) => (
            <tr key={id}>
              {columns.map((column, index) => (
                <td key={column.title} class={classOf(column)} data-title={column.part === "figure" ? column.title : undefined}>
                  {cells[index]}
                </td>
              ))}
            </tr>
          ))}
        </tbody>
      </table>
    </div>
  );
}
