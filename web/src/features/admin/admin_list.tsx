import type { ComponentChildren } from "preact";
import type { ApiResult } from "../../api/client";
import { useRequest } from "../../api/use_request";
import { Empty, ErrorNotice, Loading, PageTitle, TableFrame } from "../../widgets/basics";

interface Props<T> {
  readonly title: string;
  readonly empty: string;
  readonly ask: (signal: AbortSignal) => Promise<ApiResult<readonly T[]>>;
  readonly children: (items: readonly T[]) => ComponentChildren;
}

// A read-only list of one kind of thing with its loading, empty and failed states.
export function AdminList<T>({ title, empty, ask, children }: Props<T>) {
  const { loaded, reload } = useRequest(title, ask);
  return (
    <>
      <PageTitle document={title}>{title}</PageTitle>
      {loaded.state === "loading" && <Loading what={title.toLowerCase()} />}
      {loaded.state === "failed" && <ErrorNotice title={`${title} could not be loaded`} message={loaded.error.message} onRetry={reload} />}
      {loaded.state === "ready" && (loaded.value.length === 0 ? <Empty>{empty}</Empty> : children(loaded.value))}
    </>
  );
}

export interface Column<T> {
  readonly title: string;
  readonly number?: boolean;
  readonly cell: (item: T) => ComponentChildren;
}

// The first column names the row.
export function DataTable<T>({ label, columns, items }:
                             { readonly label: string; readonly columns: readonly Column<T>[]; readonly items: readonly T[] }) {
  return (
    <TableFrame label={label}>
      <table>
        <thead>
          <tr>{columns.map((column) => <th key={column.title} scope="col" class={column.number === true ? "number" : ""}>{column.title}</th>)}</tr>
        </thead>
        <tbody>
          {items.map((item, row) => (
            <tr key={row}>
              {columns.map((column, i) => i === 0
                ? <th key={column.title} scope="row">{column.cell(item)}</th>
                : <td key={column.title} class={column.number === true ? "number" : ""}>{column.cell(item)}</td>)}
            </tr>
          ))}
        </tbody>
      </table>
    </TableFrame>
  );
}
