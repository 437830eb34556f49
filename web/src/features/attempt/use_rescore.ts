import { useEffect, useMemo, useState } from "preact/hooks";
import type { Client } from "../../api/client";
import type { ApiResult } from "../../api/http";
import type { AttemptDetail } from "../../api/types";
import { useRefresh } from "../../api/use_refresh";

const kPollMs = 1500;

// A scoring run that was asked for. It first waits in a queue, where the attempt still shows its earlier score.
export interface Awaited {
  readonly newest: number; // run when it was asked for
  readonly problem: string; // of the attempt at that time
  readonly begun: boolean; // the attempt was seen while it was being scored
}

// Whether the run is over: its result is there, or it failed and left the earlier score.
export function isOver(
  { newest, problem, begun }: Awaited,
  newestNow: number,
  { state, problem: problemNow }: Pick<AttemptDetail, "state" | "problem">,
): boolean {
  if (state !== "scored" && state !== "failed") return false;
  return newestNow > newest || begun || problemNow !== problem;
}

export interface Rescore {
  readonly state: "none" | "waiting" | "done";
  readonly over: number; // of the runs that were asked for here; what was loaded before the last one is out of date
  // Sends a request that queues a scoring run, then follows the run to its end.
  readonly ask: <T>(send: () => Promise<ApiResult<T>>) => Promise<ApiResult<T>>;
}

async function newestRun(client: Client, id: string): Promise<number | undefined> {
  const runs = await client.all("/attempts/{id}/results", { id });
  return runs.ok ? (runs.value[0]?.run ?? 0) : undefined;
}

export function useRescore(client: Client, attempt: AttemptDetail | undefined, reload: () => void): Rescore {
  const [awaited, setAwaited] = useState<Awaited>();
  const [newest, setNewest] = useState(0);
  const [done, setDone] = useState(false);
  const [over, setOver] = useState(0);
  const id = attempt?.id;
  const look = useMemo(
    () => () => {
      reload();
      if (id !== undefined) void newestRun(client, id).then((run) => run !== undefined && setNewest(run));
    },
    [client, id, reload],
  );
  useRefresh(awaited !== undefined, kPollMs, look);
  useEffect(() => {
    if (awaited === undefined || attempt === undefined) return;
    if (attempt.state === "scoring" && !awaited.begun) setAwaited({ ...awaited, begun: true });
    if (!isOver(awaited, newest, attempt)) return;
    setAwaited(undefined);
    setDone(attempt.problem === "");
    setOver((count) => count + 1);
    reload();
  }, [awaited, attempt, newest, reload]);
  return {
    over,
    state: awaited !== undefined ? "waiting" : done ? "done" : "none",
    ask: async (send) => {
      const before = (id === undefined ? undefined : await newestRun(client, id)) ?? 0;
      const result = await send();
      if (!result.ok) return result;
      setDone(false);
      setNewest(before);
      setAwaited({ newest: before, problem: attempt?.problem ?? "", begun: false });
      return result;
    },
  };
}
