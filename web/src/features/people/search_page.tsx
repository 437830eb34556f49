import type { ComponentChildren } from "preact";
import { useEffect, useRef, useState } from "preact/hooks";
import { wordedTitle } from "../../api/builtin_words";
import type { Client } from "../../api/client";
import type { ApiResult } from "../../api/http";
import { useRequest } from "../../api/use_request";
import { formatDateTime, formatScore } from "../../base/format";
import { nameHas } from "../../base/names";
import { ok } from "../../base/result";
import { say } from "../../base/words";
import { Card, Empty, ErrorNotice, Loading, PageTitle } from "../../widgets/basics";
import { TextField } from "../../widgets/form";

const kMost = 10; // of each kind
const kMostPeople = 3; // whose attempts are shown
const kLeastLetters = 2;
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
  const enough = asked.trim().length >= kLeastLetters;
  return (
    <>
      <PageTitle document={say("search.title")}>{say("search.title")}</PageTitle>
      <div ref={field} role="search">
        <TextField label={say("search.for")} hint={say("search.hint")} value={text} onValue={setText} maxLength={100} />
      </div>
      {enough && (
        <div class="columns">
          <Results title={say("nav.people")} asked={asked} find={(signal) => people(client, asked, signal)} />
          <Results title={say("nav.attempts")} asked={asked} find={(signal) => attempts(client, asked, signal)} />
          <Results title={say("nav.exercises")} asked={asked} find={(signal) => exercises(client, asked, signal)} />
          <Results title={say("nav.stations")} asked={asked} find={(signal) => stations(client, asked, signal)} />
        </div>
      )}
    </>
  );
}

function Results({
  title,
  asked,
  find,
}: {
  readonly title: string;
  readonly asked: string;
  readonly find: (signal: AbortSignal) => Promise<ApiResult<readonly Found[]>>;
}) {
  const { loaded, reload } = useRequest(asked, find);
  return <Card title={title}>{shown()}</Card>;

  function shown(): ComponentChildren {
    if (loaded.state === "loading") return <Loading what={say("loading.short")} />;
    if (loaded.state === "failed")
      return <ErrorNotice title={say("search.failed")} message={loaded.error.message} onRetry={reload} />;
    if (loaded.value.length === 0) return <Empty>{say("search.nothing")}</Empty>;
    return (
      <ul class="found">
        {loaded.value.map(({ key, path, title: name, more }) => (
          <li key={key}>
            <a href={path}>{name}</a> {more}
          </li>
        ))}
      </ul>
    );
  }
}

async function people(client: Client, text: string, signal: AbortSignal): Promise<ApiResult<readonly Found[]>> {
  const read = await client.people.list({ text, limit: kMost }, signal);
  if (!read.ok) return read;
  return ok(
    read.value.items.map(({ id, display_name: title, login, role }) => ({
      key: id,
      path: `/people/${id}`,
      title,
      more: `${login}, ${say(`role.${role}`)}`,
    })),
  );
}

// The newest of the first people who are found.
async function attempts(client: Client, text: string, signal: AbortSignal): Promise<ApiResult<readonly Found[]>> {
  const found = await client.people.list({ text, limit: kMostPeople }, signal);
  if (!found.ok) return found;
  const out: Found[] = [];
  for (const { id: person } of found.value.items) {
    const read = await client.attempts({ person, limit: kMost }, signal);
    if (!read.ok) return read;
    for (const { id, exercise, person: whose, ticketed_ms: when, score } of read.value.items)
      out.push({
        key: id,
        path: `/attempts/${id}`,
        title: `${whose.display_name}, ${wordedTitle(exercise.title)}`,
        more: `${formatDateTime(when)}${score === null ? "" : `, ${formatScore(score)}`}`,
      });
  }
  return ok(out.slice(0, kMost));
}

async function exercises(client: Client, text: string, signal: AbortSignal): Promise<ApiResult<readonly Found[]>> {
  const read = await client.teaching.exercises("published", signal);
  if (!read.ok) return read;
  return ok(
    read.value
      .map(({ id, title, name }) => ({ key: id, path: `/exercises/${id}`, title: wordedTitle(title), more: name }))
      .filter(({ title, more }) => nameHas(title, text) || nameHas(more, text))
      .slice(0, kMost),
  );
}

async function stations(client: Client, text: string, signal: AbortSignal): Promise<ApiResult<readonly Found[]>> {
  const read = await client.stations.all(signal);
  if (!read.ok) return read;
  return ok(
    read.value
      .filter(({ name }) => nameHas(name, text))
      .slice(0, kMost)
      .map(({ id, name, software }) => ({ key: id, path: "/stations", title: name, more: software })),
  );
}
