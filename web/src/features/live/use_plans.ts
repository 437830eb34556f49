import { useEffect, useMemo, useRef, useState } from "preact/hooks";
import type { Client } from "../../api/client";
import type { Exercise } from "../../api/types";
import { useRefresh } from "../../api/use_refresh";
import { studio } from "../../tooth/link";
import type { ToothPlan } from "../../tooth/messages";
import { kFromAbove, kFromSide, type Side } from "./tool_view";

export type ToothPlans = Readonly<Record<Side["name"], ToothPlan>>;

const kAgainMs = 5000;

// The tooth of each exercise as it is before anything is cut, by the exercise's id. A class works on few teeth: each
// is read once. What cannot be read is asked for again after a while; until it comes, the tool is shown without it.
export function usePlans(client: Client, exercises: readonly Exercise[]): ReadonlyMap<string, ToothPlans> {
  const [plans, setPlans] = useState<ReadonlyMap<string, ToothPlans>>(new Map());
  const [missed, setMissed] = useState(false);
  const [round, setRound] = useState(0);
  const asked = useRef(new Set<string>());
  const ids = exercises.map(({ id }) => id).join(" ");
  useEffect(() => {
    setMissed(false);
    for (const id of ids === "" ? [] : ids.split(" ")) {
      if (asked.current.has(id)) continue;
      asked.current.add(id);
      void readPlans(client, id).then((read) => {
        if (read !== undefined) return setPlans((now) => new Map(now).set(id, read));
        asked.current.delete(id);
        setMissed(true);
      });
    }
  }, [client, ids, round]);
  const again = useMemo(() => () => setRound((now) => now + 1), []);
  useRefresh(missed, kAgainMs, again);
  return plans;
}

async function readPlans(client: Client, id: string): Promise<ToothPlans | undefined> {
  const surface = await client.bytes("/exercises/{id}/initial-surface", { id });
  if (!surface.ok) return undefined;
  const film = studio().film(() => undefined);
  const plans = await film.plans(surface.value, [kFromAbove, kFromSide]);
  film.close();
  const [above, side] = plans.ok ? plans.value : [];
  return above === undefined || side === undefined ? undefined : { above, side };
}
