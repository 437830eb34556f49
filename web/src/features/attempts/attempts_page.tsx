import { useEffect, useMemo, useState } from "preact/hooks";
import { exerciseTitle } from "../../api/builtin_words";
import type { Client } from "../../api/client";
import type { Asked } from "../../api/contract";
import type { Attempt, AttemptFlag, AttemptState, ExerciseSummary, ListedCohort } from "../../api/types";
import { usePages } from "../../api/use_pages";
import { useRefresh } from "../../api/use_refresh";
import { useRequest } from "../../api/use_request";
import { formatDateTime, formatScore } from "../../base/format";
import { say } from "../../base/words";
import {
  flagText,
  Flags,
  isUnderWay,
  kFlagTones,
  kStateTones,
  StateBadge,
  stateText,
} from "../../widgets/attempt_state";
import { Badge, PageTitle, Waits } from "../../widgets/basics";
import { SelectField, TextField } from "../../widgets/form";
import { PagedList } from "../../widgets/pages";
import { type Column, DataTable } from "../../widgets/table";

const kPageSize = 50;
const kMaxAppeals = 200; // that are told of at once
const kNobody: ReadonlySet<string> = new Set();
const kPollMs = 3000;
const kTypingMs = 250; // after which somebody has finished typing

interface Props {
  readonly client: Client;
  readonly mine: boolean; // a student's own list: no cohort, no names
  readonly query: URLSearchParams;
  readonly onQuery: (query: Readonly<Record<string, string>>) => void;
}

// What the list is narrowed to, as the address has it.
type Filter = Readonly<
  Record<"cohort" | "exercise" | "state" | "special" | "assignment" | "person" | "name" | "by", string>
>;

export function AttemptsPage({ client, mine, query, onQuery }: Props) {
  const filter: Filter = {
    cohort: query.get("cohort") ?? "",
    exercise: query.get("exercise") ?? "",
    state: query.get("state") ?? "",
    special: query.get("special") ?? "",
    assignment: query.get("assignment") ?? "",
    person: query.get("person") ?? "",
    name: query.get("name") ?? "",
    by: query.get("by") ?? "",
  };
  const exercises = useRequest("exercises", (signal) => client.all("/exercises", { signal }));
  const known = exercises.loaded.state === "ready" ? exercises.loaded.value : [];
  return (
    <>
      <PageTitle document={say("nav.attempts")}>{mine ? say("nav.my_attempts") : say("nav.attempts")}</PageTitle>
      {mine ? (
        <AttemptList client={client} filter={filter} exercises={known} named={false} />
      ) : (
        <CohortAttempts client={client} filter={filter} exercises={known} onQuery={onQuery} />
      )}
    </>
  );
}

interface ListProps {
  readonly client: Client;
  readonly filter: Filter;
  readonly exercises: readonly ExerciseSummary[];
}

function CohortAttempts({ client, filter, exercises, onQuery }: ListProps & { readonly onQuery: Props["onQuery"] }) {
  const { loaded, reload } = useRequest("cohorts", (signal) => client.all("/cohorts", { signal }));
  const appeals = useRequest("appeals", (signal) =>
    client.page("/attempts", { appeal: "open", limit: kMaxAppeals, signal }),
  );
  const appealed = useMemo(
    () => new Set(appeals.loaded.state === "ready" ? appeals.loaded.value.items.map(({ id }) => id) : []),
    [appeals.loaded],
  );
  if (loaded.state !== "ready")
    return <Waits loaded={loaded} reload={reload} what={say("loading.cohorts")} failed={say("list_failed.cohorts")} />;
  return (
    <>
      <Filters cohorts={loaded.value} exercises={exercises} filter={filter} onQuery={onQuery} />
      {appealed.size > 0 && filter.special !== "appeal" && (
        <p>
          <Badge tone="warning">{say("attempts.appeals", { count: appealed.size })}</Badge>{" "}
          <button type="button" class="button small" onClick={() => onQuery({ special: "appeal" })}>
            {say("attempts.show_appeals", { count: appealed.size })}
          </button>
        </p>
      )}
      {(filter.assignment !== "" || filter.person !== "") && (
        <p class="hint">
          {filter.person === ""
            ? say("attempts.only_assignment")
            : filter.assignment === ""
              ? say("attempts.only_person")
              : say("attempts.only_both")}{" "}
          <button type="button" class="button small" onClick={() => onQuery({ ...filter, assignment: "", person: "" })}>
            {say("attempts.show_all")}
          </button>
        </p>
      )}
      <AttemptList client={client} filter={filter} exercises={exercises} named={true} appealed={appealed} />
    </>
  );
}

function Filters({
  cohorts,
  exercises,
  filter,
  onQuery,
}: {
  readonly cohorts: readonly ListedCohort[];
  readonly exercises: readonly ExerciseSummary[];
  readonly filter: Filter;
  readonly onQuery: Props["onQuery"];
}) {
  const chosen = cohorts.find((cohort) => cohort.id === filter.cohort);
  const students = chosen?.students;
  return (
    <div class="filters">
      <TextField
        label={say("common.student")}
        value={filter.name}
        onValue={(name) => onQuery({ ...filter, name })}
        maxLength={100}
      />
      <SelectField
        label={say("common.cohort")}
        value={filter.cohort}
        onValue={(cohort) => onQuery({ ...filter, cohort })}
        options={[
          { value: "", title: say("common.all") },
          ...cohorts.map((cohort) => ({ value: cohort.id, title: cohort.name })),
        ]}
      />
      <SelectField
        label={say("common.exercise")}
        value={filter.exercise}
        onValue={(exercise) => onQuery({ ...filter, exercise })}
        options={[
          { value: "", title: say("common.all") },
          ...exercises.map((exercise) => ({ value: exercise.id, title: exerciseTitle(exercise) })),
        ]}
      />
      <SelectField
        label={say("common.state")}
        value={filter.state}
        onValue={(state) => onQuery({ ...filter, state })}
        options={[
          { value: "", title: say("common.any") },
          ...Object.keys(kStateTones).map((state) => ({ value: state, title: stateText(state as AttemptState).title })),
        ]}
      />
      <SelectField
        label={say("attempts.only_with")}
        value={filter.special}
        onValue={(special) => onQuery({ ...filter, special })}
        options={[
          { value: "", title: "–" },
          { value: "appeal", title: say("attempts.open_appeal") },
          ...Object.keys(kFlagTones).map((flag) => ({ value: flag, title: flagText(flag as AttemptFlag).title })),
        ]}
      />
      <SelectField
        label={say("attempts.order")}
        value={filter.by}
        onValue={(by) => onQuery({ ...filter, by })}
        options={[
          { value: "", title: say("attempts.newest") },
          { value: "name", title: say("attempts.by_name") },
          { value: "lowest", title: say("attempts.lowest") },
        ]}
      />
      {students !== undefined && <span class="hint">{say("count.students", { count: students })}</span>}
    </div>
  );
}

function queryOf({ cohort, exercise, state, special, assignment, person, by }: Filter): Asked<"GET", "/attempts"> {
  return {
    cohort,
    exercise,
    assignment,
    person,
    ...(by === "name" ? { order: "name" } : by === "lowest" ? { order: "lowest_score" } : {}),
    ...(state === "" ? {} : { state: state as AttemptState }),
    ...(special === "appeal" ? { appeal: "open" } : special === "" ? {} : { flag: special as AttemptFlag }),
  };
}

// Polls while it shows only the first page and something on it is in progress.
function AttemptList({
  client,
  filter,
  exercises,
  named,
  appealed = kNobody,
}: ListProps & { readonly named: boolean; readonly appealed?: ReadonlySet<string> }) {
  const name = useSettled(filter.name, kTypingMs);
  const pages = usePages(JSON.stringify([queryOf(filter), name]), (cursor, signal) =>
    client.page("/attempts", { ...queryOf(filter), name, cursor, limit: kPageSize, signal }),
  );
  const practice = new Set(exercises.filter((exercise) => !exercise.graded).map((exercise) => exercise.id));
  const polling = pages.onlyFirst && pages.items.some((attempt) => isUnderWay(attempt.state));
  useRefresh(polling, kPollMs, pages.reload);
  const open = (attempt: Attempt, text: string) => <a href={`/attempts/${attempt.id}`}>{text}</a>;
  const columns: readonly Column<Attempt>[] = [
    ...(named
      ? [
          { title: say("common.student"), cell: (attempt: Attempt) => open(attempt, attempt.person.display_name) },
          { title: say("common.exercise"), cell: (attempt: Attempt) => exerciseTitle(attempt.exercise) },
        ]
      : [
          {
            title: say("common.exercise"),
            cell: (attempt: Attempt) => open(attempt, exerciseTitle(attempt.exercise)),
          },
        ]),
    { title: say("common.when"), cell: (attempt) => formatDateTime(attempt.ticketed_ms) },
    { title: say("common.score"), number: true, cell: (attempt) => <ScoreCell attempt={attempt} /> },
    { title: say("common.state"), cell: (attempt) => <StateBadge attempt={attempt} /> },
    {
      title: say("attempts.flags"),
      cell: (attempt) => (
        <Flags
          attempt={attempt}
          graded={!practice.has(attempt.exercise.id) || attempt.exam}
          staff={named}
          appealed={appealed.has(attempt.id)}
        />
      ),
    },
  ];
  return (
    <PagedList
      pages={pages}
      list="attempts"
      empty={filter.name === "" ? say("attempts.none") : say("common.nobody_named")}
    >
      {(attempts) => (
        <div class="card flush">
          <DataTable label={say("nav.attempts")} items={attempts} rowKey={({ id }) => id} columns={columns} />
        </div>
      )}
    </PagedList>
  );
}

function ScoreCell({ attempt }: { readonly attempt: Attempt }) {
  const set = attempt.score !== null && attempt.computed_score !== null && attempt.score !== attempt.computed_score;
  return (
    <span class="score-cell">
      {formatScore(attempt.score)}
      {set && <span class="sub">{say("attempts.computed", { score: formatScore(attempt.computed_score) })}</span>}
    </span>
  );
}

// The value once it has stayed the same for a while: what somebody types is asked for once and not letter by letter.
function useSettled<T>(value: T, afterMs: number): T {
  const [settled, setSettled] = useState(value);
  useEffect(() => {
    const timer = setTimeout(() => setSettled(value), afterMs);
    return () => clearTimeout(timer);
  }, [value, afterMs]);
  return settled;
}
