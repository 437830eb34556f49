import { useEffect, useRef, useState } from "preact/hooks";
import type { Client } from "../../api/client";
import type { Exercise } from "../../api/types";
import { studio } from "../../tooth/link";
import type { ToothPlan } from "../../tooth/messages";
import { kFromAbove, kFromSide, type Side } from "./tool_view";

export type ToothPlans = Readonly<Record<Side["name"], ToothPlan>>;

// The tooth of each exercise as it is before anything is cut, by the exercise's id. A class works on few teeth: each
// is read once. What cannot be read is left out, and the tool is shown without it.
export function usePlans(client: Client, exercises: readonly Exercise[]): ReadonlyMap<string, ToothPlans> {
  const [plans, setPlans] = useState<ReadonlyMap<string, ToothPlans>>(new Map());
  const asked = useRef(new Set<string>());
  const ids = exercises.map(({ id }) => id).join(" ");
  useEffect(() => {
    for (const id of ids === "" ? [] : ids.split(" ")) {
      if (asked.current.has(id)) continue;
      asked.current.add(id);
      void readPlans(client, id).then((read) => {
        if (read !== undefined) setPlans((now) => new Map(now).set(id, read));
      });
    }
  }, [client, ids]);
  return plans;
}

async function readPlans(client: Client, id: string): Promise<ToothPlans | undefined> {
  const surface = await client.teaching.initialSurface(id);
  if (!surface.ok) return undefined;
  const film = studio().film(() => undefined);
  const plans = await film.plans(surface.value, [kFromAbove, kFromSide]);
  film.close();
  const [above, side] = plans.ok ? plans.value : [];
  return above === undefined || side === undefined ? undefined : { above, side };
}
