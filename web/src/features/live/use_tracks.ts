import { useEffect, useRef, useState } from "preact/hooks";
import { watchAttempt } from "../../api/live";
import { Rotation } from "../../base/rotation";
import { emptyTrack, kDefaultRateHz, type Track, withRows } from "./track";

const kMaxStreams = 3; // browsers allow six connections to a server, over all tabs
const kTurnMs = 2500; // long enough for rows that come twice a second

export interface Watched {
  readonly id: string;
  readonly rateHz: number;
}

// The tracks of all `watched` attempts, few of them streaming at a time, each in turn.
export function useTracks(watched: readonly Watched[], onEnd: () => void): ReadonlyMap<string, Track> {
  const [tracks, setTracks] = useState<ReadonlyMap<string, Track>>(new Map());
  const rates = useRef<ReadonlyMap<string, number>>(new Map());
  rates.current = new Map(watched.map(({ id, rateHz }) => [id, rateHz]));
  const ended = useRef(onEnd);
  ended.current = onEnd;
  const rotation = useRef<Rotation | undefined>(undefined);

  useEffect(() => {
    const change = (id: string, next: (track: Track) => Track) =>
      setTracks((now) => new Map(now).set(id, next(now.get(id) ?? emptyTrack)));
    const pool = new Rotation(kMaxStreams, (id) =>
      watchAttempt(id, {
        onRows: (rows) =>
          change(id, (track) => withRows(track, rows, rates.current.get(id) ?? kDefaultRateHz, Date.now())),
        onEnd: () => {
          change(id, (track) => ({ ...track, state: "ended" }));
          ended.current();
        },
        onProblem: (problem) => change(id, (track) => ({ ...track, state: "disturbed", problem })),
      }),
    );
    rotation.current = pool;
    const timer = setInterval(() => {
      if (!document.hidden) pool.turn();
    }, kTurnMs);
    return () => {
      clearInterval(timer);
      pool.dispose();
    };
  }, []);

  const ids = watched.map(({ id }) => id).join(" ");
  useEffect(() => rotation.current?.follow(ids === "" ? [] : ids.split(" ")), [ids]);
  return tracks;
}
