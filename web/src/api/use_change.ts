import { useMemo, useRef, useState } from "preact/hooks";
import type { ApiError, ApiResult } from "./http";

export interface Change {
  readonly busy: boolean;
  readonly error: ApiError | undefined;
  // Runs one change at a time; a second one while the first is under way is dropped. The answer is
  // given back, undefined for what was dropped.
  readonly run: <T>(ask: () => Promise<ApiResult<T>>) => Promise<ApiResult<T> | undefined>;
  readonly clear: () => void;
}

// A request that changes something: whether it is under way, and why the last one failed.
export function useChange(): Change {
  const [busy, setBusy] = useState(false);
  const [error, setError] = useState<ApiError>();
  const running = useRef(false);
  const run = useMemo(
    () =>
      async <T>(ask: () => Promise<ApiResult<T>>) => {
        if (running.current) return undefined;
        running.current = true;
        setBusy(true);
        const result = await ask();
        running.current = false;
        setBusy(false);
        setError(result.ok ? undefined : result.error);
        return result;
      },
    [],
  );
  const clear = useMemo(() => () => setError(undefined), []);
  return { busy, error, run, clear };
}
