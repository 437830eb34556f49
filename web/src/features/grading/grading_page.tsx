import { useEffect, useMemo, useRef, useState } from "preact/hooks";
import type { Client } from "../../api/client";
import type { ApiResult } from "../../api/http";
import { readAll } from "../../api/read_all";
import type { Attempt, Score } from "../../api/types";
import { useRequest } from "../../api/use_request";
import { formatDateTime, formatPoints, formatScore, plural } from "../../base/format";
import { keepQueue } from "../../base/queue";
import { ok } from "../../base/result";
import { awaitsRelease, Flags, StateBadge, stoppedEarly } from "../../widgets/attempt_state";
import { Card, Empty, ErrorNotice, Loading, PageTitle, TableFrame } from "../../widgets/basics";
import { TextField } from "../../widgets/form";
import { KeysHelp, useKeys } from "../../widgets/keys";
import { BulkActions } from "./bulk_actions";
import { inTurn } from "./bulk";
import { criteriaOf, type CriterionColumn, type GradingRow, lostOn, named, type Order, sorted } from "./rows";

const kPageSize = 200;
const kAtOnce = 3;                              // of the scores that are read

interface Props {
  readonly client: Client;
  readonly query: URLSearchParams;
  readonly onOpen: (path: string) => void;
}

// Everything that was made under an assignment or in a cohort, criterion by criterion, to be judged one after the other.
export function GradingPage({ client, query, onOpen }: Props) {
  if ((query.get("assignment") ?? query.get("cohort") ?? "") === "") {
    return (
      <>
        <PageTitle document="Grading">Grading</PageTitle>
        <p>What is to be graded? Open one of your <a href="/assignments">assignments</a> or <a href="/cohorts">cohorts</a>, and choose “Grade” or “Grading” there.</p>
      </>
    );
  }
  return <GradingTable client={client} query={query} onOpen={onOpen} />;
}

function GradingTable({ client, query, onOpen }: Props) {
  const [assignment, cohort] = [query.get("assignment") ?? "", query.get("cohort") ?? ""];
  const key = `${assignment} ${cohort}`;
  const back = `/grading?${new URLSearchParams(assignment !== "" ? { assignment } : { cohort }).toString()}`;
  const { loaded, reload } = useRequest(key, (signal) => readAll((cursor) => client.attempts({ assignment, cohort, cursor, limit: kPageSize }, signal)));
  const title = useRequest(key, async (signal): Promise<ApiResult<string>> => {
    if (assignment === "") {
      const found = await client.people.cohort(cohort, signal);
      return found.ok ? ok(found.value.value.name) : found;
    }
    const found = await client.teaching.assignment(assignment, signal);
    return found.ok ? ok(found.value.value.exercise.title ?? found.value.value.exercise.name) : found;
  });
  const exercises = useRequest("exercises", (signal) => client.teaching.exercises(undefined, signal));
  const practice = new Set(exercises.loaded.state === "ready" ? exercises.loaded.value.filter((exercise) => !exercise.graded).map(({ id }) => id) : []);
  const attempts = loaded.state === "ready" ? loaded.value : kNone;
  const scores = useScores(client, attempts);
  const [text, setText] = useState("");
  const [order, setOrder] = useState<Order>({ by: "name", down: false });
  const [chosen, setChosen] = useState<ReadonlySet<string>>(new Set());
  const rows = useMemo(() => attempts.map((attempt): GradingRow => ({ attempt, score: scores.get(scoreKey(attempt)) })), [attempts, scores]);
  const criteria = useMemo(() => criteriaOf(rows), [rows]);
  const shown = useMemo(() => sorted(named(rows, text), order), [rows, text, order]);
  const graded = (attempt: Attempt) => attempt.exam || !practice.has(attempt.exercise.id);
  const open = (id: string | undefined) => {
    if (id === undefined) return;
    keepQueue({ back, ids: shown.map(({ attempt }) => attempt.id) });
    onOpen(`/attempts/${id}`);
  };
  const toggle = (id: string, on = !chosen.has(id)) => setChosen((now) => { const next = new Set(now); if (on) next.add(id); else next.delete(id); return next; });
  const search = useRef<HTMLDivElement>(null);
  const body = useRef<HTMLTableSectionElement>(null);
  const focused = () => body.current?.querySelector<HTMLElement>("tr:focus-within")?.dataset["id"];
  const move = (by: number) => {
    const ids = shown.map(({ attempt }) => attempt.id);
    const at = ids.indexOf(focused() ?? "");
    const id = ids[Math.min(Math.max(at < 0 ? (by > 0 ? 0 : ids.length - 1) : at + by, 0), ids.length - 1)];
    body.current?.querySelector<HTMLElement>(`tr[data-id="${id}"] a`)?.focus();
  };
  const keys = useKeys([
    { key: "j", what: "Next row", act: () => move(1) }, { key: "k", what: "Row before", act: () => move(-1) },
    { key: "x", what: "Choose the row, or not", act: () => { const id = focused(); if (id !== undefined) toggle(id); } },
    { key: "o", what: "Open the row, or the first one", act: () => open(focused() ?? shown[0]?.attempt.id) },
    { key: "/", what: "Search a name", act: () => search.current?.querySelector("input")?.focus() },
  ]);
  if (title.loaded.state === "failed") {
    return <ErrorNotice title={assignment !== "" ? "This assignment could not be opened" : "This cohort could not be opened"} message={title.loaded.error.message} onRetry={title.reload} />;
  }
  const name = title.loaded.state === "ready" ? title.loaded.value : assignment !== "" ? "the assignment" : "the cohort";
  const picked = rows.filter(({ attempt }) => chosen.has(attempt.id)).map(({ attempt }) => attempt);
  const firstWaiting = shown.find(({ attempt }) => awaitsRelease(attempt, graded(attempt)));
  const waiting = rows.filter(({ attempt }) => awaitsRelease(attempt, graded(attempt))).length;
  return (
    <>
      <nav class="trail" aria-label="Where you are"><a href={assignment !== "" ? `/assignments/${assignment}` : `/cohorts/${cohort}`}>{name}</a></nav>
      <div class="toolbar"><PageTitle document={`Grading ${name}`}>Grading: {name}</PageTitle><KeysHelp keys={keys} /></div>
      <div class="filters" role="search" ref={search}>
        <TextField label="Student" value={text} onValue={setText} maxLength={100} />
        <span class="hint">{plural(shown.length, "attempt")}, {waiting} to be released</span>
        <button type="button" class="button primary" disabled={shown.length === 0} onClick={() => open((firstWaiting ?? shown[0])?.attempt.id)}>Begin with the first</button>
      </div>
      <BulkActions client={client} chosen={picked} onDone={() => { setChosen(new Set()); reload(); }} />
      {loaded.state === "loading" && <Loading what="attempts" />}
      {loaded.state === "failed" && <ErrorNotice title="The attempts could not be loaded" message={loaded.error.message} onRetry={reload} />}
      {loaded.state === "ready" && (shown.length === 0 ? <Empty>{rows.length === 0 ? "No attempt yet." : "Nobody has that name."}</Empty> : (
        <Card className="flush">
          <TableFrame label="Attempts to be graded">
            <table class="grading">
              <Head criteria={criteria} order={order} onOrder={setOrder} all={shown.every(({ attempt }) => chosen.has(attempt.id))}
                    onAll={(on) => setChosen(on ? new Set(shown.map(({ attempt }) => attempt.id)) : new Set())} />
              <tbody ref={body}>
                {shown.map((row) => (
                  <tr key={row.attempt.id} data-id={row.attempt.id}>
                    <td><input type="checkbox" aria-label={`Choose ${row.attempt.person.display_name}, ${formatDateTime(row.attempt.ticketed_ms)}`} checked={chosen.has(row.attempt.id)}
                               onChange={(event) => toggle(row.attempt.id, event.currentTarget.checked)} /></td>
                    <th scope="row" class="nowrap">
                      <a href={`/attempts/${row.attempt.id}`} onClick={(event) => {
                        if (event.button !== 0 || event.metaKey || event.ctrlKey || event.shiftKey || event.altKey) return;
                        event.preventDefault();
                        open(row.attempt.id);
                      }}>{row.attempt.person.display_name}</a>
                    </th>
                    <td class="nowrap">{formatDateTime(row.attempt.ticketed_ms)}</td>
                    <td class="number score-cell">{formatScore(row.attempt.score)}</td>
                    <td class="nowrap">{row.attempt.released ? "Released" : awaitsRelease(row.attempt, graded(row.attempt)) ? "Waits" : <span class="hint">–</span>}</td>
                    {criteria.map((criterion) => <Lost key={criterion.name} row={row} criterion={criterion} />)}
                    <td>{row.attempt.state !== "scored" && <StateBadge attempt={row.attempt} />} <Flags attempt={row.attempt} graded={graded(row.attempt)} staff={true} done={row.score === undefined ? undefined : stoppedEarly(row.score)} /></td>
                  </tr>
                ))}
              </tbody>
            </table>
          </TableFrame>
        </Card>
      ))}
      <p class="hint">Each criterion's column says how many points were lost. A title sorts by it.</p>
    </>
  );
}

const kNone: readonly Attempt[] = [];

function Head({ criteria, order, onOrder, all, onAll }:
    { readonly criteria: readonly CriterionColumn[]; readonly order: Order; readonly onOrder: (order: Order) => void; readonly all: boolean; readonly onAll: (on: boolean) => void }) {
  // What one looks for comes first: names from A, the newest, the lowest score, most points lost.
  const column = (by: string, title: string, downFirst: boolean, number = false) => {
    const current = order.by === by;
    return (
      <th key={by} scope="col" class={number ? "number" : ""} {...(current ? { "aria-sort": order.down ? "descending" as const : "ascending" as const } : {})}>
        <button type="button" class="sort" onClick={() => onOrder({ by, down: current ? !order.down : downFirst })}>{title}<span aria-hidden="true">{current ? (order.down ? " ▾" : " ▴") : ""}</span></button>
      </th>
    );
  };
  return (
    <thead>
      <tr>
        <th scope="col"><input type="checkbox" aria-label="Choose all that are shown" checked={all} onChange={(event) => onAll(event.currentTarget.checked)} /></th>
        {column("name", "Student", false)}{column("when", "When", true)}{column("score", "Score", false, true)}
        <th scope="col">Release</th>
        {criteria.map(({ name, title }) => column(name, title, true, true))}
        <th scope="col">State</th>
      </tr>
    </thead>
  );
}

function Lost({ row, criterion }: { readonly row: GradingRow; readonly criterion: CriterionColumn }) {
  const lost = lostOn(row, criterion.name);
  const max = row.score?.criteria.find(({ name }) => name === criterion.name)?.max_points ?? 0;
  if (lost === undefined) return <td class="number hint">–</td>;
  const share = max > 0 ? lost / max : 0;
  return <td class={share >= 0.5 ? "number lost-much" : share >= 0.05 ? "number lost-some" : "number hint"}>{lost < 0.05 ? "0" : `−${formatPoints(lost)}`}</td>;
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
    const wanted = attempts.filter((attempt) => attempt.computed_score !== null && !known.current.has(scoreKey(attempt)));
    const fresh = new Map<string, Score>();
    void inTurn(wanted, kAtOnce, async (attempt) => {
      if (abort.signal.aborted) return;
      const score = await client.score(attempt.id, abort.signal);
      if (score.ok) fresh.set(scoreKey(attempt), score.value);
      // Not at every single one: each draws the whole table.
      if (fresh.size % 12 === 0 && !abort.signal.aborted) setScores((now) => new Map([...now, ...fresh]));
    }).then(() => { if (!abort.signal.aborted) setScores((now) => new Map([...now, ...fresh])); });
    return () => abort.abort();
  }, [client, attempts]);
  return scores;
}
