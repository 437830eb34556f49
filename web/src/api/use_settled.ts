import { useEffect, useState } from "preact/hooks";

// The value once it has stayed the same for a while: what somebody types is asked for once and not letter by letter.
export function useSettled<T>(value: T, afterMs: number): T {
  const [settled, setSettled] = useState(value);
  useEffect(() => {
    const timer = setTimeout(() => setSettled(value), afterMs);
    return () => clearTimeout(timer);
  }, [value, afterMs]);
  return settled;
}
