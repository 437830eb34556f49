import { useEffect, useState } from "preact/hooks";
import { say } from "../../base/words";
import { type FilmLink, studio } from "../../tooth/link";
import type { Compared, Extent } from "../../tooth/messages";

// A tooth that stays as it is.
export interface StillFilm {
  readonly film: FilmLink;
  readonly extent: Extent;
  readonly tissues: readonly number[];
  readonly compared: Compared | undefined; // undefined: with nothing
}
export type StillFilmState =
  | { readonly state: "loading" }
  | { readonly state: "failed"; readonly error: { readonly message: string } }
  | { readonly state: "ready"; readonly value: StillFilm };

// Of a surface as the server sends it (tooth/surface.ts); undefined: it is not here yet.
export function useStillFilm(bytes: ArrayBuffer | undefined): StillFilmState {
  const [shown, setShown] = useState<StillFilmState>({ state: "loading" });
  useEffect(() => {
    if (bytes === undefined) return undefined;
    let film: FilmLink;
    let there: Omit<StillFilm, "compared"> | undefined;
    try {
      film = studio().film((told) => {
        if (told.told === "detail") there = { film, extent: told.extent, tissues: told.tissues };
        if (told.told === "failed")
          setShown({ state: "failed", error: { message: say("error.malformed", { found: told.message }) } });
        if (told.told === "compared" && told.compared.ok && there !== undefined)
          setShown({ state: "ready", value: { ...there, compared: told.compared.value } });
      });
    } catch {
      setShown({ state: "failed", error: { message: say("tooth.no_webgl") } });
      return undefined;
    }
    film.surface(bytes.slice(0));
    return () => {
      film.close();
      setShown({ state: "loading" });
    };
  }, [bytes]);
  return shown;
}
