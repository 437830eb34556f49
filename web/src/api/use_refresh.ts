import { useEffect } from "preact/hooks";

// Calls `reload` every `everyMs` while `on` and while somebody can see the page.
export function useRefresh(on: boolean, everyMs: number, reload: () => void): void {
  useEffect(() => {
    if (!on) return undefined;
    const timer = setInterval(() => {
      if (!document.hidden) reload();
    }, everyMs);
    return () => clearInterval(timer);
  }, [on, everyMs, reload]);
}
