import type { ComponentChildren } from "preact";
import { TableFrame } from "./basics";

export interface Column<T> {
  readonly title: string;
  readonly number?: boolean;
  readonly hideTitle?: boolean; // for a column of buttons: the title is for screen readers only
  readonly cell: (item: T) => ComponentChildren;
}

interface Props<T> {
  readonly label: string;
  readonly columns: readonly Column<T>[];
  readonly items: readonly T[];
  readonly rowKey?: (item: T) => string;
  readonly dense?: boolean;
}

// A table of things; the first column names the row. On a narrow screen each row becomes a small
// card with the column's title before each value, so that nothing has to be scrolled sideways; the
// roles are written out because browsers drop a table's own when it is laid out otherwise.
export function DataTable<T>({ label, columns, items, rowKey, dense = false }: Props<T>) {
  return (
    <TableFrame label={label}>
      <table class={`stacking${dense ? " dense" : ""}`} role="table" aria-label={label}>
        <thead role="rowgroup">
          <tr role="row">
            {columns.map((column) => (
              <th key={column.title} scope="col" role="columnheader" class={classOf(column)}>
                {column.hideTitle === true ? <span class="hidden">{column.title}</span> : column.title}
              </th>
            ))}
          </tr>
        </thead>
        <tbody role="rowgroup">
          {items.map((item, row) => (
            <tr key={rowKey?.(item) ?? row} role="row">
              {columns.map((column, i) =>
                i === 0 ? (
                  <th key={column.title} scope="row" role="rowheader" class={classOf(column)}>
                    {column.cell(item)}
                  </th>
                ) : (
                  <td key={column.title} role="cell" class={classOf(column)} {...titleOf(column)}>
                    {column.cell(item)}
                  </td>
                ),
              )}
            </tr>
          ))}
        </tbody>
      </table>
    </TableFrame>
  );
}

function classOf(column: { readonly number?: boolean }): string {
  return column.number === true ? "number" : "";
}

function titleOf(column: { readonly title: string; readonly hideTitle?: boolean }) {
  return column.hideTitle === true ? {} : { "data-title": column.title };
}
