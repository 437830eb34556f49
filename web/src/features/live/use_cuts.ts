import { useEffect, useRef, useState } from "preact/hooks";
import type { Client } from "../../api/client";
import { type Cut, withColumns } from "./cut";

const kPollMs = 500; // one attempt at a time, each in turn: one that is watched alone twice a second

// What has been cut in each of these attempts. What cannot be read is asked for again at its next turn.
export function useCuts(client: Client, watched: readonly string[]): ReadonlyMap<string, Cut> {
  const [cuts, setCuts] = useState<ReadonlyMap<string, Cut>>(new Map());
  const known = useRef(new Map<string, Cut>());
  const ids = watched.join(" ");
  useEffect(() => {
    const turns = ids === "" ? [] : ids.split(" ");
    let timer = 0;
    let left = false;
    const look = async (turn: number): Promise<void> => {
      const id = turns[turn % turns.length];
      if (id === undefined) return;
      if (!document.hidden) {
        const before = known.current.get(id);
        const answer = await client.get("/attempts/{id}/live-cut", { id, from: before?.chunks ?? 0 });
        if (left) return;
        if (answer.ok) {
          known.current.set(id, withColumns(before, answer.value));
          if (answer.value.columns.length > 0) setCuts(new Map(known.current));
        }
      }
      timer = window.setTimeout(() => void look(turn + 1), kPollMs);
    };
    void look(0);
    return () => {
      left = true;
      clearTimeout(timer);
    };
  }, [client, ids]);
  return cuts;
}
