import { useEffect, useMemo, useRef, useState } from "preact/hooks";
import { wordedTitle } from "../../api/builtin_words";
import type { Client } from "../../api/client";
import { type ApiResult, queryText, readAll } from "../../api/http";
import type { Attempt, Score } from "../../api/types";
import { scoreOf } from "../../api/worded";
import { useRequest } from "../../api/use_request";
import { formatDateTime, formatPoints, formatScore } from "../../base/format";
import { keepQueue } from "../../base/queue";
import { ok } from "../../base/result";
import { say, sayWith } from "../../base/words";
import { awaitsRelease, FlagIcons, StateBadge, stoppedEarly } from "../../widgets/attempt_state";
import { Card, Empty, ErrorNotice, Loading, PageTitle, TableFrame } from "../../widgets/basics";
import { Button } from "../../widgets/button";
import { TextField } from "../../widgets/form";
import { KeysHelp, useKeys } from "../../widgets/keys";
import { useReleaseUndo } from "../../widgets/release_undo";
import { BulkActions } from "./bulk_actions";
import { inTurn } from "./bulk";
import { criteriaOf, type CriterionColumn, type GradingRow, lostOn, named, type Order, sorted } from "./rows";

const kPageSize = 200;
const kAtOnce = 3; // of the scores that are read

interface Props {
  readonly client: Client;
  readonly query: URLSearchParams; // also keeps search, order and the row that was opened
  readonly onQuery: (query: Readonly<Record<string, string>>) => void;
  readonly onOpen: (path: string) => void;
}

// Everything that was made under an assignment or in a cohort, criterion by criterion, to be judged
// one after the other.
export function GradingPage({ client, query, onQuery, onOpen }: Props) {
  if ((query.get("assignment") ?? query.get("cohort") ?? "") === "") {
    return (
      <>
        <PageTitle document={say("grading.title")}>{say("grading.title")}</PageTitle>
        <p>
          {sayWith("grading.what", {
            assignments: <a href="/assignments">{say("grading.assignments")}</a>,
            cohorts: <a href="/cohorts">{say("grading.cohorts")}</a>,
          })}
        </p>
      </>
    );
  }
  return <GradingTable client={client} query={query} onQuery={onQuery} onOpen={onOpen} />;
}

function GradingTable({ client, query, onQuery, onOpen }: Props) {
  const [assignment, cohort] = [query.get("assignment") ?? "", query.get("cohort") ?? ""];
  const key = `${assignment} ${cohort}`;
  const { loaded, reload } = useRequest(key, (signal) =>
    readAll((cursor) => client.attempts({ assignment, cohort, cursor, limit: kPageSize }, signal)),
  );
  const title = useRequest(key, async (signal): Promise<ApiResult<string>> => {
    if (assignment === "") {
      const found = await client.people.cohort(cohort, signal);
      return found.ok ? ok(found.value.value.name) : found;
    }
    const found = await client.teaching.assignment(assignment, signal);
    return found.ok
      ? ok(wordedTitle(found.value.value.exercise.title ?? "") || found.value.value.exercise.name)
      : found;
  });
  const exercises = useRequest("exercises", (signal) => client.teaching.exercises(undefined, signal));
  const practice = new Set(
    exercises.loaded.state === "ready"
      ? exercises.loaded.value.filter((exercise) => !exercise.graded).map(({ id }) => id)
      : [],
  );
  const attempts = loaded.state === "ready" ? loaded.value : kNone;
  const scores = useScores(client, attempts);
  const text = query.get("name") ?? "";
  const order = useMemo((): Order => ({ by: query.get("by") ?? "name", down: query.get("down") !== null }), [query]);
  // As the address has it, so that Back finds the list as it was.
  const shownAs = (now: Order, name: string, row = ""): Readonly<Record<string, string>> => ({
    ...(assignment !== "" ? { assignment } : { cohort }),
    name,
    by: now.by === "name" ? "" : now.by,
    down: now.down ? "1" : "",
    row,
  });
  const setText = (next: string) => onQuery(shownAs(order, next));
  const setOrder = (next: Order) => onQuery(shownAs(next, text));
  const [chosen, setChosen] = useState<ReadonlySet<string>>(new Set());
  const rows = useMemo(
    () => attempts.map((attempt): GradingRow => ({ attempt, score: scores.get(scoreKey(attempt)) })),
    [attempts, scores],
  );
  const criteria = useMemo(() => criteriaOf(rows), [rows]);
  const shown = useMemo(() => sorted(named(rows, text), order), [rows, text, order]);
  const graded = (attempt: Attempt) => attempt.exam || !practice.has(attempt.exercise.id);
  const open = (id: string | undefined) => {
    if (id === undefined) return;
    const here = shownAs(order, text, id);
    onQuery(here);
    keepQueue({ back: `/grading${queryText(here)}`, ids: shown.map(({ attempt }) => attempt.id) });
    onOpen(`/attempts/${id}`);
  };
  const toggle = (id: string, on = !chosen.has(id)) =>
    setChosen((now) => {
      const next = new Set(now);
      if (on) next.add(id);
      else next.delete(id);
      return next;
    });
  const search = useRef<HTMLDivElement>(null);
  const body = useRef<HTMLTableSectionElement>(null);
  const focused = () => body.current?.querySelector<HTMLElement>("tr:focus-within")?.dataset["id"];
  const opened = useRef(query.get("row")); // where one was when one left
  useEffect(() => {
    if (opened.current === null || shown.length === 0) return;
    body.current?.querySelector<HTMLElement>(`tr[data-id="${CSS.escape(opened.current)}"] a`)?.focus();
    opened.current = null;
  }, [shown]);
  const move = (by: number) => {
    const ids = shown.map(({ attempt }) => attempt.id);
    const at = ids.indexOf(focused() ?? "");
    const id = ids[Math.min(Math.max(at < 0 ? (by > 0 ? 0 : ids.length - 1) : at + by, 0), ids.length - 1)];
    body.current?.querySelector<HTMLElement>(`tr[data-id="${id}"] a`)?.focus();
  };
  const undo = useReleaseUndo(async (released) => {
    const now = await client.attempt(released); // with what others changed meanwhile
    const result = now.ok ? await client.teaching.withdrawRelease(now.value) : now;
    reload();
    return result;
  });
  const keys = useKeys([
    ...undo.keys,
    { key: "j", what: say("grading.next_row"), act: () => move(1) },
    { key: "k", what: say("grading.row_before"), act: () => move(-1) },
    {
      key: "x",
      what: say("grading.choose_row"),
      act: () => {
        const id = focused();
        if (id !== undefined) toggle(id);
      },
    },
    { key: "o", what: say("grading.open_row"), act: () => open(focused() ?? shown[0]?.attempt.id) },
    { key: "/", what: say("grading.search_name"), act: () => search.current?.querySelector("input")?.focus() },
  ]);
  if (title.loaded.state === "failed") {
    return (
      <ErrorNotice
        title={assignment !== "" ? say("grading.assignment_failed") : say("grading.cohort_failed")}
        message={title.loaded.error.message}
        onRetry={title.reload}
      />
    );
  }
  const name =
    title.loaded.state === "ready"
      ? title.loaded.value
      : assignment !== ""
        ? say("grading.the_assignment")
        : say("grading.the_cohort");
  const picked = rows.filter(({ attempt }) => chosen.has(attempt.id)).map(({ attempt }) => attempt);
  const firstWaiting = shown.find(({ attempt }) => awaitsRelease(attempt, graded(attempt)));
  const waiting = rows.filter(({ attempt }) => awaitsRelease(attempt, graded(attempt))).length;
  return (
    <>
      <nav class="trail" aria-label={say("common.where")}>
        <a href={assignment !== "" ? `/assignments/${assignment}` : `/cohorts/${cohort}`}>{name}</a>
      </nav>
      <div class="toolbar">
        <PageTitle document={say("grading.of", { name })}>{say("grading.of", { name })}</PageTitle>
        <KeysHelp keys={keys} />
      </div>
      <div class="filters" role="search" ref={search}>
        <TextField label={say("common.student")} value={text} onValue={setText} maxLength={100} />
        <span class="hint">{say("grading.count", { count: shown.length, waiting })}</span>
        <Button
          blocked={shown.length > 0 ? undefined : rows.length === 0 ? say("grading.none") : say("common.nobody_named")}
          onClick={() => open((firstWaiting ?? shown[0])?.attempt.id)}
        >
          {say("grading.begin")}
        </Button>
      </div>
      {undo.notice}
      <BulkActions
        client={client}
        chosen={picked}
        onDone={() => {
          setChosen(new Set());
          reload();
        }}
      />
      {loaded.state === "loading" && <Loading what={say("loading.attempts")} />}
      {loaded.state === "failed" && (
        <ErrorNotice title={say("list_failed.attempts")} message={loaded.error.message} onRetry={reload} />
      )}
      {loaded.state === "ready" &&
        (shown.length === 0 ? (
          <Empty>{rows.length === 0 ? say("grading.none") : say("common.nobody_named")}</Empty>
        ) : (
          <Card className="flush">
            <TableFrame label={say("grading.table")}>
              <table class="grading">
                <Head
                  criteria={criteria}
                  order={order}
                  onOrder={setOrder}
                  all={shown.every(({ attempt }) => chosen.has(attempt.id))}
                  onAll={(on) => setChosen(on ? new Set(shown.map(({ attempt }) => attempt.id)) : new Set())}
                />
                <tbody ref={body}>
                  {shown.map((row) => (
                    <tr key={row.attempt.id} data-id={row.attempt.id}>
                      <td>
                        <input
                          type="checkbox"
                          aria-label={say("grading.choose", {
                            name: row.attempt.person.display_name,
                            begun: formatDateTime(row.attempt.ticketed_ms),
                          })}
                          checked={chosen.has(row.attempt.id)}
                          onChange={(event) => toggle(row.attempt.id, event.currentTarget.checked)}
                        />
                      </td>
                      <th scope="row" class="nowrap">
                        <a
                          href={`/attempts/${row.attempt.id}`}
                          onClick={(event) => {
                            if (event.button !== 0 || event.metaKey || event.ctrlKey || event.shiftKey || event.altKey)
                              return;
                            event.preventDefault();
                            open(row.attempt.id);
                          }}
                        >
                          {row.attempt.person.display_name}
                        </a>
                      </th>
                      <td class="nowrap">
                        {row.attempt.state !== "scored" && <StateBadge attempt={row.attempt} />}{" "}
                        <FlagIcons
                          attempt={row.attempt}
                          graded={graded(row.attempt)}
                          staff={true}
                          done={row.score === undefined ? undefined : stoppedEarly(row.score)}
                        />
                      </td>
                      <td class="nowrap">{formatDateTime(row.attempt.ticketed_ms)}</td>
                      <td class="number score-cell">{formatScore(row.attempt.score)}</td>
                      <td class="nowrap">
                        {row.attempt.released ? (
                          say("grading.released")
                        ) : awaitsRelease(row.attempt, graded(row.attempt)) ? (
                          say("grading.waits")
                        ) : (
                          <span class="hint">–</span>
                        )}
                      </td>
                      {criteria.map((criterion) => (
                        <Lost key={criterion.name} row={row} criterion={criterion} />
                      ))}
                    </tr>
                  ))}
                </tbody>
              </table>
            </TableFrame>
          </Card>
        ))}
      <p class="hint">{say("grading.columns_hint")}</p>
    </>
  );
}

const kNone: readonly Attempt[] = [];

function Head({
  criteria,
  order,
  onOrder,
  all,
  onAll,
}: {
  readonly criteria: readonly CriterionColumn[];
  readonly order: Order;
  readonly onOrder: (order: Order) => void;
  readonly all: boolean;
  readonly onAll: (on: boolean) => void;
}) {
  // What one looks for comes first: names from A, the newest, the lowest score, most points lost.
  const column = (by: string, title: string, downFirst: boolean, number = false) => {
    const current = order.by === by;
    return (
      <th
        key={by}
        scope="col"
        class={number ? "number" : ""}
        {...(current ? { "aria-sort": order.down ? ("descending" as const) : ("ascending" as const) } : {})}
      >
        <button type="button" class="sort" onClick={() => onOrder({ by, down: current ? !order.down : downFirst })}>
          {title}
          <span aria-hidden="true">{current ? (order.down ? " ▾" : " ▴") : ""}</span>
        </button>
      </th>
    );
  };
  return (
    <thead>
      <tr>
        <th scope="col">
          <input
            type="checkbox"
            aria-label={say("grading.choose_all")}
            checked={all}
            onChange={(event) => onAll(event.currentTarget.checked)}
          />
        </th>
        {column("name", say("common.student"), false)}
        <th scope="col">{say("attempts.flags")}</th>
        {column("when", say("common.when"), true)}
        {column("score", say("common.score"), false, true)}
        <th scope="col">{say("grading.release")}</th>
        {criteria.map(({ name, title }) => column(name, title, true, true))}
      </tr>
    </thead>
  );
}

function Lost({ row, criterion }: { readonly row: GradingRow; readonly criterion: CriterionColumn }) {
  const lost = lostOn(row, criterion.name);
  const max = row.score?.criteria.find(({ name }) => name === criterion.name)?.max_points ?? 0;
  if (lost === undefined) return <td class="number hint">–</td>;
  const share = max > 0 ? lost / max : 0;
  return (
    <td class={share >= 0.5 ? "number lost-much" : share >= 0.05 ? "number lost-some" : "number hint"}>
      {lost < 0.05 ? "0" : `−${formatPoints(lost)}`}
    </td>
  );
}

// Of an attempt as it is now: a set score, a new run and a new reference change it.
function scoreKey({ id, revision, computed_score: computed }: Attempt): string {
  return `${id} ${revision} ${computed}`;
}

// The scores of all of them, as they come.
function useScores(client: Client, attempts: readonly Attempt[]): ReadonlyMap<string, Score> {
  const [scores, setScores] = useState<ReadonlyMap<string, Score>>(new Map());
  const known = useRef(scores);
  known.current = scores;
  useEffect(() => {
    const abort = new AbortController();
    const wanted = attempts.filter(
      (attempt) => attempt.computed_score !== null && !known.current.has(scoreKey(attempt)),
    );
    const fresh = new Map<string, Score>();
    void inTurn(wanted, kAtOnce, async (attempt) => {
      if (abort.signal.aborted) return;
      const score = await scoreOf(client, attempt.id, abort.signal);
      if (score.ok) fresh.set(scoreKey(attempt), score.value);
      // Not at every single one: each draws the whole table.
      if (fresh.size % 12 === 0 && !abort.signal.aborted) setScores((now) => new Map([...now, ...fresh]));
    }).then(() => {
      if (!abort.signal.aborted) setScores((now) => new Map([...now, ...fresh]));
    });
    return () => abort.abort();
  }, [client, attempts]);
  return scores;
}
