const kAgainMs = [1_000, 2_000, 4_000, 8_000, 15_000] as const;
const kMaxMs = 30_000; // from then on

// When to try again what failed for the `tries`th time, counted from 0.
export function againMs(tries: number): number {
  return kAgainMs[tries] ?? kMaxMs;
}

// Calls `again` after a while, and as soon as the network is back. Returns what stops that.
function later(again: () => void, afterMs: number): () => void {
  const timer = setTimeout(again, afterMs);
  window.addEventListener("online", again);
  return () => {
    clearTimeout(timer);
    window.removeEventListener("online", again);
  };
}

// Loads until it is there, less and less often. `failed` hears of each failure. Nothing is loaded or resolved once
// `until` is aborted.
export function keepTrying<T>(
  load: () => Promise<T>,
  until: AbortSignal,
  failed = () => {},
  wait: typeof later = later,
): Promise<T> {
  return new Promise((resolve) => {
    const attempt = (tries: number): void => {
      load().then(
        (value) => {
          if (!until.aborted) resolve(value);
        },
        () => {
          if (until.aborted) return;
          failed();
          const stop = wait(() => {
            stop();
            until.removeEventListener("abort", stop);
            attempt(tries + 1);
          }, againMs(tries));
          until.addEventListener("abort", stop);
        },
      );
    };
    attempt(0);
  });
}
