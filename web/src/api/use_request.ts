import { useEffect, useLayoutEffect, useMemo, useRef, useState } from "preact/hooks";
import type { ApiError, ApiResult } from "./http";

export type Loaded<T> =
  | { readonly state: "loading" }
  | { readonly state: "ready"; readonly value: T }
  | { readonly state: "failed"; readonly error: ApiError };

export interface Request<T> {
  readonly loaded: Loaded<T>;
  // Asks again; what is shown stays until the answer is there.
  readonly reload: () => void;
}

const kRetryMs = [2_000, 4_000, 8_000, 15_000, 30_000] as const; // the last one from then on

// Loads on mount and whenever `key` changes; an answer to an older key is dropped. With `key`
// undefined nothing is asked and the state stays "loading". Where the server cannot be reached it
// is asked again, less and less often, and as soon as the network is back.
export function useRequest<T>(
  key: string | undefined,
  ask: (signal: AbortSignal) => Promise<ApiResult<T>>,
): Request<T> {
  const [loaded, setLoaded] = useState<Loaded<T> & { key?: string }>({ state: "loading" });
  const [round, setRound] = useState(0);
  const latestAsk = useRef(ask);
  latestAsk.current = ask;

  // Before the page is painted: where the answer was asked for ahead, nobody sees that it was waited for.
  useLayoutEffect(() => {
    if (key === undefined) return undefined;
    const abort = new AbortController();
    void latestAsk.current(abort.signal).then((result) => {
      if (abort.signal.aborted) return;
      setLoaded(
        result.ok ? { state: "ready", value: result.value, key } : { state: "failed", error: result.error, key },
      );
    });
    return () => abort.abort();
  }, [key, round]);

  const away = loaded.state === "failed" && isAway(loaded.error);
  const tries = useRef(0);
  useEffect(() => {
    if (!away) {
      tries.current = 0;
      return undefined;
    }
    const again = () => setRound((value) => value + 1);
    const timer = setTimeout(again, kRetryMs[Math.min(tries.current++, kRetryMs.length - 1)]);
    window.addEventListener("online", again);
    return () => {
      clearTimeout(timer);
      window.removeEventListener("online", again);
    };
  }, [away, loaded]);

  const reload = useMemo(() => () => setRound((value) => value + 1), []);
  return { loaded: key !== undefined && loaded.key === key ? loaded : { state: "loading" }, reload };
}

// A server that starts again, or a proxy without one.
function isAway({ code, status }: ApiError): boolean {
  return code === "unreachable" || status === 502 || status === 503 || status === 504;
}
