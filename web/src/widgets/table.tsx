import type { ComponentChildren } from "preact";
import { TableFrame } from "./basics";
import { kWhole } from "./row_place";
import { Rows } from "./rows";

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
      <table class={`stacking${dense ? " dense" : ""}`} role="table" aria-label={label} {...rowCount(items.length)}>
        <thead role="rowgroup">
          <tr role="row">
            {columns.map((column) => (
              <th key={column.title} scope="col" role="columnheader" class={classOf(column)}>
                {column.hideTitle === true ? <span class="hidden">{column.title}</span> : column.title}
              </th>
            ))}
          </tr>
        </thead>
        <Rows
          keys={items.map((item, row) => rowKey?.(item) ?? String(row))}
          row={(index, place) => (
            <tr role="row" {...place}>
              {columns.map((column, i) =>
                i === 0 ? (
                  <th key={column.title} scope="row" role="rowheader" class={classOf(column)}>
                    {column.cell(items[index]!)}
                  </th>
                ) : (
                  <td key={column.title} role="cell" class={classOf(column)} {...titleOf(column)}>
                    {column.cell(items[index]!)}
                  </td>
                ),
              )}
            </tr>
          )}
        />
      </table>
    </TableFrame>
  );
}

// Of a table whose rows are not all in the page.
export function rowCount(rows: number) {
  return rows > kWhole ? { "aria-rowcount": rows + 1 } : {};
}

function classOf(column: { readonly number?: boolean }): string {
  return column.number === true ? "number" : "";
}

function titleOf(column: { readonly title: string; readonly hideTitle?: boolean }) {
  return column.hideTitle === true ? {} : { "data-title": column.title };
}
