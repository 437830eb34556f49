import type { ComponentChildren } from "preact";
import type { Pages } from "../api/use_pages";
import { say } from "../base/words";
import { Empty, ErrorNotice, Loading } from "./basics";

interface Props<T> {
  readonly pages: Pages<T>;
  readonly list: "attempts" | "people" | "cohorts" | "stations" | "profiles" | "jobs" | "audit";
  readonly empty: string;
  readonly children: (items: readonly T[]) => ComponentChildren;
}

// A list that comes page by page, with its loading, empty and failed states and the button for
// more.
export function PagedList<T>({ pages, list, empty, children }: Props<T>) {
  if (pages.state === "loading") return <Loading what={say(`list_loading.${list}`)} />;
  if (pages.state === "failed")
    return (
      <ErrorNotice title={say(`list_failed.${list}`)} message={pages.error?.message ?? ""} onRetry={pages.reload} />
    );
  if (pages.items.length === 0) return <Empty>{empty}</Empty>;
  return (
    <>
      {children(pages.items)}
      {pages.error !== undefined && <ErrorNotice title={say("common.more_failed")} message={pages.error.message} />}
      {pages.hasMore && (
        <p class="more">
          <button type="button" class="button" onClick={() => void pages.loadMore()}>
            {say("common.show_more")}
          </button>
        </p>
      )}
    </>
  );
}
