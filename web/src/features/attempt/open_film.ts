import type { Client } from "../../api/client";
import type { Result } from "../../base/result";
import type { FilmLink } from "../../tooth/link";

export type Opened = Result<readonly number[], string>;

// Each tooth is opened once, however often it is cut.
const opened = new WeakMap<FilmLink, Promise<Opened>>();

export function openFilm(client: Client, film: FilmLink, start: string): Promise<Opened> {
  const known = opened.get(film);
  if (known !== undefined) return known;
  const made = client
    .bytes("/start-teeth/{name}", { name: start, kept: true })
    .then((bytes): Opened | Promise<Opened> =>
      bytes.ok ? film.interior(bytes.value) : { ok: false, error: bytes.error.message },
    );
  opened.set(film, made);
  void made.then((told) => {
    if (!told.ok) opened.delete(film);
  });
  return made;
}
