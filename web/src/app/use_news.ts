import { useEffect, useState } from "preact/hooks";
import type { Client } from "../api/client";
import { troubles } from "../api/trouble";
import type { Role } from "../api/types";
import { say } from "../base/words";

const kEveryMs = 60_000;
const kMaxAppeals = 9; // more are said as "9+"

// What waits on a page of the navigation, by its path.
export type News = Readonly<Record<string, { readonly count: string; readonly what: string }>>;

// Appeals that wait for an answer, and, for admins, what stops the server's work. Looked up each minute while the page
// is seen; what cannot be looked up is left out, since the page that it is about says why.
export function useNews(client: Client, role: Role): News {
  const [news, setNews] = useState<News>({});
  useEffect(() => {
    if (role === "student") return undefined;
    const abort = new AbortController();
    const look = async () => {
      if (document.visibilityState === "hidden") return;
      const [appeals, health] = await Promise.all([
        client.page("/attempts", { appeal: "open", limit: kMaxAppeals + 1, signal: abort.signal }),
        role === "admin" ? client.get("/health", { signal: abort.signal }) : undefined,
      ]);
      if (abort.signal.aborted) return;
      const waiting = appeals.ok ? appeals.value.items.length : 0;
      const bad = health?.ok === true ? troubles(health.value) : 0;
      setNews({
        ...(waiting === 0
          ? {}
          : {
              "/attempts": {
                count: waiting > kMaxAppeals ? `${kMaxAppeals}+` : String(waiting),
                what: say("nav.appeals_wait", { count: waiting }),
              },
            }),
        ...(bad === 0 ? {} : { "/health": { count: String(bad), what: say("nav.troubles", { count: bad }) } }),
      });
    };
    void look();
    const timer = setInterval(() => void look(), kEveryMs);
    return () => {
      clearInterval(timer);
      abort.abort();
    };
  }, [client, role]);
  return news;
}
