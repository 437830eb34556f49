import { useEffect, useState } from "preact/hooks";
import type { ApiError, Client } from "../../api/client";
import type { Attempt, Cohort } from "../../api/types";
import { useRequest } from "../../api/use_request";
import { formatDateTime, formatScore, plural } from "../../base/format";
import { Flags, isUnderWay, StateBadge } from "../../widgets/attempt_state";
import { Empty, ErrorNotice, Loading, PageTitle, TableFrame } from "../../widgets/basics";

const kPageSize = 50;
const kPollMs = 3000;

interface Props {
  readonly client: Client;
  readonly mine: boolean;                       // a student's own list: no cohort, no names
  readonly cohort: string | undefined;          // from the address
  readonly onCohort: (id: string) => void;
}

export function AttemptsPage({ client, mine, cohort, onCohort }: Props) {
  return (
    <>
      <PageTitle document="Attempts">{mine ? "My attempts" : "Attempts"}</PageTitle>
      {mine ? <AttemptList client={client} cohort={undefined} named={false} />
            : <CohortAttempts client={client} cohort={cohort} onCohort={onCohort} />}
    </>
  );
}

function CohortAttempts({ client, cohort, onCohort }: Omit<Props, "mine">) {
  const { loaded, reload } = useRequest("cohorts", (signal) => client.cohorts(signal));
  if (loaded.state === "loading") return <Loading what="cohorts" />;
  if (loaded.state === "failed") return <ErrorNotice title="The cohorts could not be loaded" message={loaded.error.message} onRetry={reload} />;
  const { cohorts } = loaded.value;
  const chosen = cohorts.find((item) => item.id === cohort) ?? cohorts[0];
  if (chosen === undefined) return <Empty>No cohort is assigned to you. An administrator adds instructors to cohorts.</Empty>;
  return (
    <>
      <CohortPicker cohorts={cohorts} chosen={chosen} onCohort={onCohort} />
      <AttemptList key={chosen.id} client={client} cohort={chosen.id} named={true} />
    </>
  );
}

function CohortPicker({ cohorts, chosen, onCohort }:
                      { readonly cohorts: readonly Cohort[]; readonly chosen: Cohort; readonly onCohort: (id: string) => void }) {
  const students = chosen.members.filter((member) => member.role === "student").length;
  return (
    <div class="picker">
      <label for="cohort">Cohort</label>
      <select id="cohort" value={chosen.id} onChange={(event) => onCohort(event.currentTarget.value)}>
        {cohorts.map((cohort) => <option key={cohort.id} value={cohort.id}>{cohort.name}</option>)}
      </select>
      <span class="hint">{plural(students, "student")}</span>
    </div>
  );
}

// Loads page by page. While only the first page is shown and something in it is under way, it is asked for again.
function AttemptList({ client, cohort, named }:
                     { readonly client: Client; readonly cohort: string | undefined; readonly named: boolean }) {
  const first = useRequest(cohort ?? "own", (signal) => client.attempts({ cohort, limit: kPageSize }, signal));
  const exercises = useRequest("exercises", (signal) => client.exercises(signal));
  const practice = new Set(exercises.loaded.state === "ready"
    ? exercises.loaded.value.exercises.filter((exercise) => !exercise.graded).map((exercise) => exercise.id) : []);
  const [more, setMore] = useState<readonly Attempt[]>([]);
  const [next, setNext] = useState<string | null | undefined>();  // undefined: as the first page says
  const [error, setError] = useState<ApiError>();

  const page = first.loaded.state === "ready" ? first.loaded.value : undefined;
  const polling = more.length === 0 && (page?.attempts.some((attempt) => isUnderWay(attempt.state)) ?? false);
  useEffect(() => {
    if (!polling) return undefined;
    const timer = setInterval(() => { if (!document.hidden) first.reload(); }, kPollMs);
    return () => clearInterval(timer);
  }, [polling, first.reload]);

  if (first.loaded.state === "failed") {
    return <ErrorNotice title="The attempts could not be loaded" message={first.loaded.error.message} onRetry={first.reload} />;
  }
  if (page === undefined) return <Loading what="attempts" />;
  const attempts = [...page.attempts, ...more];
  if (attempts.length === 0) return <Empty>No attempt yet. They appear here while they are recorded at a station.</Empty>;
  const before = next === undefined ? page.next : next;
  const loadMore = async () => {
    if (before === null) return;
    const result = await client.attempts({ cohort, limit: kPageSize, before });
    setError(result.ok ? undefined : result.error);
    if (!result.ok) return;
    setMore([...more, ...result.value.attempts]);
    setNext(result.value.next);
  };
  return (
    <>
      <AttemptTable attempts={attempts} practice={practice} named={named} />
      {error !== undefined && <ErrorNotice title="More attempts could not be loaded" message={error.message} />}
      {before !== null && <button type="button" class="button" onClick={() => void loadMore()}>Show more</button>}
    </>
  );
}

function AttemptTable({ attempts, practice, named }:
                      { readonly attempts: readonly Attempt[]; readonly practice: ReadonlySet<string>; readonly named: boolean }) {
  return (
    <div class="card flush">
      <TableFrame label="Attempts">
        <table class="attempts">
          <thead>
            <tr>
              {named && <th scope="col">Student</th>}
              <th scope="col">Exercise</th><th scope="col">When</th><th scope="col" class="number">Score</th>
              <th scope="col">State</th><th scope="col">Flags</th>
            </tr>
          </thead>
          <tbody>
            {attempts.map((attempt) =>
              <AttemptRow key={attempt.id} attempt={attempt} graded={!practice.has(attempt.exercise.id)} named={named} />)}
          </tbody>
        </table>
      </TableFrame>
    </div>
  );
}

function AttemptRow({ attempt, graded, named }: { readonly attempt: Attempt; readonly graded: boolean; readonly named: boolean }) {
  const open = (text: string) => <a href={`/attempts/${attempt.id}`}>{text}</a>;
  return (
    <tr>
      {named && <th scope="row">{open(attempt.person.display_name)}</th>}
      {named ? <td>{attempt.exercise.title}</td> : <th scope="row">{open(attempt.exercise.title)}</th>}
      <td>{formatDateTime(attempt.ticketed_ms)}</td>
      <td class="number score-cell">{formatScore(attempt.score)}</td>
      <td><StateBadge attempt={attempt} /></td>
      <td><Flags attempt={attempt} graded={graded} /></td>
    </tr>
  );
}
