import { useEffect, useMemo, useRef, useState } from "preact/hooks";
import type { ApiError, ApiResult, Page } from "./http";
import { useRequest } from "./use_request";

export interface Pages<T> {
  readonly state: "loading" | "ready" | "failed";
  readonly items: readonly T[];
  readonly error: ApiError | undefined; // of the first page, or of the one asked for last
  readonly hasMore: boolean;
  readonly onlyFirst: boolean; // nothing after the first page was loaded yet
  readonly loadMore: () => Promise<void>;
  readonly reload: () => void; // from the first page on
}

// A list that comes page by page. Starts again whenever `key` changes.
export function usePages<T>(
  key: string,
  ask: (cursor: string | undefined, signal?: AbortSignal) => Promise<ApiResult<Page<T>>>,
): Pages<T> {
  const first = useRequest(key, (signal) => ask(undefined, signal));
  const [rest, setRest] = useState<{ key: string; items: readonly T[]; next: string | null }>();
  const [error, setError] = useState<ApiError>();
  const latestKey = useRef(key);
  latestKey.current = key;
  useEffect(() => setError(undefined), [key]);

  const more = rest?.key === key ? rest : undefined;
  const page = first.loaded.state === "ready" ? first.loaded.value : undefined;
  const next = more === undefined ? (page?.next ?? null) : more.next;
  const reload = useMemo(
    () => () => {
      setRest(undefined);
      setError(undefined);
      first.reload();
    },
    [first.reload],
  );
  const loadMore = async () => {
    if (next === null) return;
    const result = await ask(next);
    if (latestKey.current !== key) return;
    setError(result.ok ? undefined : result.error);
    if (result.ok) setRest({ key, items: [...(more?.items ?? []), ...result.value.items], next: result.value.next });
  };
  return {
    state: first.loaded.state,
    items: [...(page?.items ?? []), ...(more?.items ?? [])],
    error: first.loaded.state === "failed" ? first.loaded.error : error,
    hasMore: next !== null,
    onlyFirst: more === undefined,
    loadMore,
    reload,
  };
}
