import type { ComponentChildren } from "preact";
import type { Pages } from "../api/use_pages";
import { Empty, ErrorNotice, Loading } from "./basics";

interface Props<T> {
  readonly pages: Pages<T>;
  readonly what: string;                        // "people", "audit entries"
  readonly empty: string;
  readonly children: (items: readonly T[]) => ComponentChildren;
}

// A list that comes page by page, with its loading, empty and failed states and the button for more.
export function PagedList<T>({ pages, what, empty, children }: Props<T>) {
  if (pages.state === "loading") return <Loading what={what} />;
  if (pages.state === "failed") return <ErrorNotice title={`The ${what} could not be loaded`} message={pages.error?.message ?? ""} onRetry={pages.reload} />;
  if (pages.items.length === 0) return <Empty>{empty}</Empty>;
  return (
    <>
      {children(pages.items)}
      {pages.error !== undefined && <ErrorNotice title={`More ${what} could not be loaded`} message={pages.error.message} />}
      {pages.hasMore && <p class="more"><button type="button" class="button" onClick={() => void pages.loadMore()}>Show more</button></p>}
    </>
  );
}
