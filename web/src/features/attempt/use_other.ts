import { useEffect, useMemo, useState } from "preact/hooks";
import type { Client } from "../../api/client";
import type { Series } from "../../api/types";
import { useRequest } from "../../api/use_request";
import { FrameClock } from "./clock";
import { momentInOther, type Sync } from "./compare";
import type { PathMatch } from "./path_sync";
import { Playback } from "./playback";
import { useMoves } from "./use_moves";

// Another attempt that this one is compared with, kept at the moment that belongs to this one's.
export interface Other {
  readonly playback: Playback;
  readonly ready: boolean; // its tooth can be shown
  readonly at: number | undefined; // its moment, s; undefined: not known yet
  readonly sync: Sync;
  readonly setSync: (sync: Sync) => void;
}

// `id` undefined: nothing is compared, and nothing is loaded.
export function useOther(
  client: Client,
  id: string | undefined,
  series: Series | undefined,
  timeS: number,
): Other | undefined {
  const [, redraw] = useState(0);
  const [sync, setSync] = useState<Sync>("time");
  const playback = useMemo(
    () => (id === undefined ? undefined : new Playback(client, id, () => redraw((n) => n + 1))),
    [client, id],
  );
  useMoves(playback);
  useEffect(() => {
    void playback?.load();
    return () => playback?.dispose();
  }, [playback]);
  const { loaded } = useRequest(id, (signal) => client.series(id ?? "", signal));
  const theirs = loaded.state === "ready" ? loaded.value : undefined;
  const path = usePath(sync === "path" ? series : undefined, theirs, setSync);
  const clock = useMemo(
    () => (playback?.head === undefined ? undefined : new FrameClock(playback.head, playback.gaps)),
    [playback, playback?.head, playback?.whole],
  );
  const at =
    series === undefined || theirs === undefined ? undefined : momentInOther(sync, series, theirs, timeS, path);
  const ready = playback?.state.state === "ready";
  useEffect(() => {
    if (ready && clock !== undefined && at !== undefined) playback?.show(clock.framesAt(at));
  }, [playback, ready, clock, at]);
  return playback === undefined ? undefined : { playback, ready, at, sync, setSync };
}

// How two ways belong together. What works it out is fetched when it is first wanted.
function usePath(
  own: Series | undefined,
  other: Series | undefined,
  setSync: (sync: Sync) => void,
): PathMatch | undefined {
  const [known, setKnown] = useState<{ readonly own: Series; readonly other: Series; readonly match: PathMatch }>();
  useEffect(() => {
    if (own === undefined || other === undefined) return undefined;
    let abandoned = false;
    import("./path_sync")
      .then(({ pathMatch }) => {
        if (!abandoned) setKnown({ own, other, match: pathMatch(own, other) });
      })
      .catch(() => {
        if (!abandoned) setSync("time");
      });
    return () => {
      abandoned = true;
    };
  }, [own, other, setSync]);
  return known !== undefined && known.own === own && known.other === other ? known.match : undefined;
}
