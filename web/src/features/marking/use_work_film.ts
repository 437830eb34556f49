import { useEffect, useMemo, useState } from "preact/hooks";
import type { Client } from "../../api/client";
import { useRequest } from "../../api/use_request";
import { say } from "../../base/words";
import { type FilmLink, studio } from "../../tooth/link";
import type { Head } from "../../tooth/timeline";

export interface WorkFilm {
  readonly film: FilmLink;
  readonly head: Head | undefined;
  readonly drawn: boolean; // in full
  readonly tissues: readonly number[];
}
export type WorkFilmState =
  | { readonly state: "loading" }
  | { readonly state: "waits"; readonly message: string } // is being made; useRequest asks again
  | { readonly state: "failed"; readonly message: string; readonly again: (() => void) | undefined }
  | { readonly state: "ready"; readonly value: WorkFilm };

interface Told extends Omit<WorkFilm, "film"> {
  readonly problem: string;
}
const kPlaybackWaits = "playback_waits";

const kNothing: Told = { head: undefined, drawn: false, tissues: [], problem: "" };

// The work as it was cut, without anything that it was compared with.
export function useWorkFilm(client: Client, work: string): WorkFilmState {
  const { loaded, reload } = useRequest(work, (signal) =>
    client.bytes("/marking-works/{id}/timeline", { id: work, signal }),
  );
  const bytes = loaded.state === "ready" ? loaded.value : undefined;
  const [told, setTold] = useState<Told>(kNothing);
  const film = useMemo(() => {
    if (bytes === undefined) return undefined;
    try {
      return studio().film((news) => {
        if (news.told === "head") setTold((was) => ({ ...was, head: news.head }));
        if (news.told === "detail")
          setTold((was) => ({ ...was, drawn: news.detail === "fine", tissues: news.tissues }));
        if (news.told === "failed") setTold((was) => ({ ...was, problem: news.message }));
      });
    } catch {
      return undefined;
    }
  }, [bytes]);
  useEffect(() => {
    setTold(kNothing);
    if (bytes === undefined || film === undefined) return undefined;
    film.bytes(bytes.slice(0));
    return () => film.close();
  }, [bytes, film]);
  if (loaded.state === "failed" && loaded.error.field === kPlaybackWaits)
    return { state: "waits", message: loaded.error.message };
  if (loaded.state === "failed") return { state: "failed", message: loaded.error.message, again: reload };
  if (bytes === undefined) return { state: "loading" };
  if (film === undefined) return { state: "failed", message: say("tooth.no_webgl"), again: undefined };
  if (told.problem !== "")
    return { state: "failed", message: say("error.malformed", { found: told.problem }), again: undefined };
  return { state: "ready", value: { film, ...told } };
}
