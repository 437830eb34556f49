import { useEffect, useMemo, useRef, useState } from "preact/hooks";
import { exerciseTitle } from "../../api/builtin_words";
import type { Client } from "../../api/client";
import { seen } from "../../api/http";
import { queryText } from "../../api/request_init";
import type { Grading } from "../../api/types";
import { useRequest } from "../../api/use_request";
import { criterionTitle } from "../../api/worded";
import { formatDateTime, formatPoints, formatScore } from "../../base/format";
import { keepQueue } from "../../base/queue";
import { say, sayWith } from "../../base/words";
import { awaitsRelease, Flags, StateBadge } from "../../widgets/attempt_state";
import { Card, Empty, ErrorNotice, Loading, PageTitle, TableFrame } from "../../widgets/basics";
import { Button } from "../../widgets/button";
import { TextField } from "../../widgets/form";
import { KeysHelp, useKeys } from "../../widgets/keys";
import { useReleaseUndo } from "../../widgets/release_undo";
import type { RowPlace, RowsHandle } from "../../widgets/row_place";
import { Rows } from "../../widgets/rows";
import { rowCount } from "../../widgets/table";
import { BulkActions } from "./bulk_actions";
import { attemptsOf, type Criterion, type GradedAttempt, lostOn, named, type Order, sorted } from "./rows";

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
    assignment !== ""
      ? client.get("/assignments/{id}/grading", { id: assignment, signal })
      : client.get("/cohorts/{id}/grading", { id: cohort, signal }),
  );
  const grading = loaded.state === "ready" ? loaded.value : kNothing;
  const attempts = useMemo(() => attemptsOf(grading), [grading]);
  const criteria = useMemo(
    () => grading.criteria.map((criterion) => ({ ...criterion, title: criterionTitle(criterion) })),
    [grading],
  );
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
  const shown = useMemo(() => sorted(named(attempts, text), order, criteria), [attempts, text, order, criteria]);
  const graded = (attempt: GradedAttempt) => attempt.exam || attempt.exercise.graded;
  const open = (id: string | undefined) => {
    if (id === undefined) return;
    const here = shownAs(order, text, id);
    onQuery(here);
    keepQueue({ back: `/grading${queryText(here)}`, ids: shown.map(({ id: each }) => each) });
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
  const table = useRef<HTMLTableElement>(null);
  const rows = useRef<RowsHandle>(null);
  const focused = () => {
    const index = table.current?.querySelector<HTMLElement>("tr[data-index]:focus-within")?.dataset["index"];
    return index === undefined ? -1 : Number(index);
  };
  const opened = useRef(query.get("row")); // where one was when one left
  useEffect(() => {
    if (opened.current === null || shown.length === 0) return;
    const at = shown.findIndex(({ id }) => id === opened.current);
    if (at >= 0) rows.current?.focus(at);
    opened.current = null;
  }, [shown]);
  const move = (by: number) => {
    const at = focused();
    const last = shown.length - 1;
    if (last >= 0) rows.current?.focus(Math.min(Math.max(at < 0 ? (by > 0 ? 0 : last) : at + by, 0), last));
  };
  const undo = useReleaseUndo(async (released) => {
    const now = await client.get("/attempts/{id}", { id: released }); // with what others changed meanwhile
    const result = now.ok ? await client.delete("/attempts/{id}/release", seen(now.value)) : now;
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
        const id = shown[focused()]?.id;
        if (id !== undefined) toggle(id);
      },
    },
    { key: "o", what: say("grading.open_row"), act: () => open((shown[focused()] ?? shown[0])?.id) },
    { key: "/", what: say("grading.search_name"), act: () => search.current?.querySelector("input")?.focus() },
  ]);
  const keysOfRows = useMemo(() => shown.map(({ id }) => id), [shown]);
  if (loaded.state === "failed") {
    return (
      <ErrorNotice
        title={assignment !== "" ? say("grading.assignment_failed") : say("grading.cohort_failed")}
        message={loaded.error.message}
        onRetry={reload}
      />
    );
  }
  const { title, graded: gradedOf } = grading.of;
  const name =
    loaded.state === "ready"
      ? gradedOf === null
        ? title
        : exerciseTitle({ title, graded: gradedOf })
      : assignment !== ""
        ? say("grading.the_assignment")
        : say("grading.the_cohort");
  const picked = attempts.filter(({ id }) => chosen.has(id));
  const waits = (attempt: GradedAttempt) => awaitsRelease(attempt, graded(attempt));
  const firstWaiting = shown.find(waits);
  const waiting = attempts.filter(waits).length;
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
          blocked={
            shown.length > 0 ? undefined : attempts.length === 0 ? say("grading.none") : say("common.nobody_named")
          }
          onClick={() => open((firstWaiting ?? shown[0])?.id)}
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
      {loaded.state === "ready" &&
        (shown.length === 0 ? (
          <Empty>{attempts.length === 0 ? say("grading.none") : say("common.nobody_named")}</Empty>
        ) : (
          <Card className="flush">
            <TableFrame label={say("grading.table")}>
              <table class="grading" ref={table} {...rowCount(shown.length)}>
                <Head
                  criteria={criteria}
                  order={order}
                  onOrder={setOrder}
                  all={shown.every(({ id }) => chosen.has(id))}
                  onAll={(on) => setChosen(on ? new Set(shown.map(({ id }) => id)) : new Set())}
                />
                <Rows
                  keys={keysOfRows}
                  handle={rows}
                  row={(index, place) => {
                    const attempt = shown[index]!;
                    return (
                      <Row
                        attempt={attempt}
                        place={place}
                        criteria={criteria}
                        graded={graded(attempt)}
                        several={grading.exercises.length > 1}
                        chosen={chosen.has(attempt.id)}
                        onChoose={toggle}
                        onOpen={open}
                      />
                    );
                  }}
                />
              </table>
            </TableFrame>
          </Card>
        ))}
      <p class="hint">{say("grading.columns_hint")}</p>
      {grading.more && <p class="hint">{say("grading.more", { count: attempts.length })}</p>}
      {grading.unread > 0 && <p class="hint">{say("grading.unread", { count: grading.unread })}</p>}
    </>
  );
}

const kNothing: Grading = {
  of: { title: "", graded: null },
  criteria: [],
  exercises: [],
  attempts: [],
  more: false,
  unread: 0,
};

interface RowProps {
  readonly attempt: GradedAttempt;
  readonly place: RowPlace;
  readonly criteria: readonly Criterion[];
  readonly graded: boolean;
  readonly several: boolean; // exercises: then the row says which
  readonly chosen: boolean;
  readonly onChoose: (id: string, on: boolean) => void;
  readonly onOpen: (id: string) => void;
}

function Row({ attempt, place, criteria, graded, several, chosen, onChoose, onOpen }: RowProps) {
  const { id, person } = attempt;
  return (
    <tr data-id={id} {...place}>
      <td>
        <input
          type="checkbox"
          aria-label={say("grading.choose", {
            name: person.display_name,
            begun: formatDateTime(attempt.ticketed_ms),
          })}
          checked={chosen}
          onChange={(event) => onChoose(id, event.currentTarget.checked)}
        />
      </td>
      <th scope="row">
        <a
          href={`/attempts/${id}`}
          onClick={(event) => {
            if (event.button !== 0 || event.metaKey || event.ctrlKey || event.shiftKey || event.altKey) return;
            event.preventDefault();
            onOpen(id);
          }}
        >
          {person.display_name}
        </a>
        {several && <span class="sub">{exerciseTitle(attempt.exercise)}</span>}
      </th>
      <td>
        {attempt.state !== "scored" && <StateBadge attempt={attempt} />}{" "}
        <Flags attempt={attempt} staff={true} done={attempt.done_percent ?? undefined} />
      </td>
      <td class="nowrap">{formatDateTime(attempt.ticketed_ms)}</td>
      <td class="number score-cell">{formatScore(attempt.score)}</td>
      <td class="nowrap">
        {attempt.released ? (
          say("grading.released")
        ) : awaitsRelease(attempt, graded) ? (
          say("grading.waits")
        ) : (
          <span class="hint">–</span>
        )}
      </td>
      {criteria.map(({ name }, at) => (
        <Lost key={name} lost={lostOn(attempt, at)} />
      ))}
    </tr>
  );
}

function Head({
  criteria,
  order,
  onOrder,
  all,
  onAll,
}: {
  readonly criteria: readonly Criterion[];
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
          <span class="sort-title" title={title}>
            {title}
          </span>
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

const kMuch = 10; // points, of a hundred
const kSome = 1;

// `lost` undefined: nobody's to lose.
function Lost({ lost }: { readonly lost: number | undefined }) {
  if (lost === undefined) return <td class="number hint">–</td>;
  return (
    <td class={lost >= kMuch ? "number lost-much" : lost >= kSome ? "number lost-some" : "number hint"}>
      {lost < 0.05 ? "0" : `−${formatPoints(lost)}`}
    </td>
  );
}
