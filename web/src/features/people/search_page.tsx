import type { ComponentChildren } from "preact";
import { useEffect, useRef, useState } from "preact/hooks";
import { exerciseTitle } from "../../api/builtin_words";
import type { Client } from "../../api/client";
import type { ApiResult } from "../../api/http";
import type { Attempt, PersonDetail } from "../../api/types";
import { type Request, useRequest } from "../../api/use_request";
import { formatDateTime, formatScore } from "../../base/format";
import { nameHas } from "../../base/names";
import { ok } from "../../base/result";
import { say } from "../../base/words";
import { Card, Empty, PageTitle, Waits } from "../../widgets/basics";
import { TextField } from "../../widgets/form";

const kMost = 10; // of each kind
const kMaxPeople = 3; // whose attempts are shown
const kMinLetters = 2;
const kWaitMs = 250; // after the last letter

interface Found {
  readonly key: string;
  readonly path: string;
  readonly title: string;
  readonly more: string;
}

interface Props {
  readonly client: Client;
  readonly query: URLSearchParams;
  readonly onQuery: (query: Readonly<Record<string, string>>) => void;
}

// People, attempts, exercises and stations whose name has what is asked for.
export function SearchPage({ client, query, onQuery }: Props) {
  const asked = query.get("q") ?? "";
  const [text, setText] = useState(asked);
  const field = useRef<HTMLDivElement>(null);
  useEffect(() => field.current?.querySelector("input")?.focus(), []);
  useEffect(() => {
    if (text === asked) return undefined;
    const timer = setTimeout(() => onQuery({ q: text }), kWaitMs);
    return () => clearTimeout(timer);
  }, [text, asked, onQuery]);
  const enough = asked.trim().length >= kMinLetters;
  const people = useRequest(enough ? asked : undefined, (signal) =>
    client.page("/people", { text: asked, limit: kMost, signal }),
  );
  const first = people.loaded.state === "ready" ? people.loaded.value.items.slice(0, kMaxPeople) : undefined;
  const attempts = useRequest(first?.map(({ id }) => id).join(" "), (signal) =>
    attemptsOf(client, first ?? [], signal),
  );
  const exercises = useRequest("exercises", (signal) => client.all("/exercises", { state: "published", signal }));
  const stations = useRequest("stations", (signal) => client.all("/stations", { signal }));
  return (
    <>
      <PageTitle document={say("search.title")}>{say("search.title")}</PageTitle>
      <div ref={field} role="search">
        <TextField label={say("search.for")} hint={say("search.hint")} value={text} onValue={setText} maxLength={100} />
      </div>
      {enough && (
        <div class="columns">
          <Results
            title={say("nav.people")}
            asking={people}
            found={({ items }) =>
              items.map(({ id, display_name: title, login, role }) => ({
                key: id,
                path: `/people/${id}`,
                title,
                more: `${login}, ${say(`role.${role}`)}`,
              }))
            }
          />
          <Results
            title={say("nav.attempts")}
            asking={people.loaded.state === "failed" ? { loaded: people.loaded, reload: people.reload } : attempts}
            found={(made) =>
              made.map(({ id, exercise, person, ticketed_ms: when, score }) => ({
                key: id,
                path: `/attempts/${id}`,
                title: `${person.display_name}, ${exerciseTitle(exercise)}`,
                more: `${formatDateTime(when)}${score === null ? "" : `, ${formatScore(score)}`}`,
              }))
            }
          />
          <Results
            title={say("nav.exercises")}
            asking={exercises}
            found={(all) =>
              all
                .map(({ id, title, name, graded }) => ({
                  key: id,
                  path: `/exercises/${id}`,
                  title: exerciseTitle({ title, graded }),
                  more: name,
                }))
                .filter(({ title, more }) => nameHas(title, asked) || nameHas(more, asked))
            }
          />
          <Results
            title={say("nav.stations")}
            asking={stations}
            found={(all) =>
              all
                .filter(({ name }) => nameHas(name, asked))
                .map(({ id, name, software }) => ({ key: id, path: "/stations", title: name, more: software }))
            }
          />
        </div>
      )}
    </>
  );
}

function Results<T>({
  title,
  asking: { loaded, reload },
  found,
}: {
  readonly title: string;
  readonly asking: Request<T>;
  readonly found: (value: T) => readonly Found[];
}) {
  return <Card title={title}>{shown()}</Card>;

  function shown(): ComponentChildren {
    if (loaded.state !== "ready")
      return <Waits loaded={loaded} reload={reload} what={say("loading.short")} failed={say("search.failed")} />;
    const all = found(loaded.value).slice(0, kMost);
    if (all.length === 0) return <Empty>{say("search.nothing")}</Empty>;
    return (
      <ul class="found">
        {all.map(({ key, path, title: name, more }) => (
          <li key={key}>
            <a href={path}>{name}</a> {more}
          </li>
        ))}
      </ul>
    );
  }
}

// The newest of each.
async function attemptsOf(
  client: Client,
  people: readonly Pick<PersonDetail, "id">[],
  signal: AbortSignal,
): Promise<ApiResult<readonly Attempt[]>> {
  const out: Attempt[] = [];
  for (const { id: person } of people) {
    const read = await client.page("/attempts", { person, limit: kMost, signal });
    if (!read.ok) return read;
    out.push(...read.value.items);
  }
  return ok(out);
}
