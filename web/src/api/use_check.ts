import { useEffect, useRef, useState } from "preact/hooks";
import type { ApiError, ApiResult } from "./http";

export interface Checked<T> {
  readonly busy: boolean; // what is shown is of what stood there before
  readonly value?: T; // the server's answer to what is right
  readonly error?: ApiError; // what is wrong
  readonly text?: string; // that was asked about
}

const kPauseMs = 350;

// Asks the server about what is being typed, when there is a pause; an answer to what stood there
// before is dropped.
export function useCheck<T>(
  text: string,
  ask: (text: string, signal: AbortSignal) => Promise<ApiResult<T>>,
): Checked<T> {
  const [checked, setChecked] = useState<Checked<T>>({ busy: true });
  const latestAsk = useRef(ask);
  latestAsk.current = ask;
  useEffect(() => {
    const abort = new AbortController();
    const timer = setTimeout(() => {
      void latestAsk.current(text, abort.signal).then((result) => {
        if (!abort.signal.aborted)
          setChecked(
            result.ok ? { busy: false, value: result.value, text } : { busy: false, error: result.error, text },
          );
      });
    }, kPauseMs);
    return () => {
      clearTimeout(timer);
      abort.abort();
    };
  }, [text]);
  return { ...checked, busy: checked.text !== text };
}
