import type { Client } from "../../api/client";
import type { Attempt, Exercise } from "../../api/types";
import { useRequest } from "../../api/use_request";
import { formatDateTime, formatNumber, formatQuantity, formatScore, micrometresAsMm } from "../../base/format";
import { Flags, StateBadge } from "../../widgets/attempt_state";
import { Badge, Card, Empty, ErrorNotice, Loading, PageTitle, TableFrame } from "../../widgets/basics";
import { burText } from "./exercises_page";

const kAttemptsShown = 50;

export function ExercisePage({ client, id, personId }:
                             { readonly client: Client; readonly id: string; readonly personId: string }) {
  const exercise = useRequest(id, (signal) => client.exercise(id, signal));
  const attempts = useRequest(`${id} ${personId}`, (signal) =>
    client.attempts({ exercise: id, person: personId, limit: kAttemptsShown }, signal));
  if (exercise.loaded.state === "loading") return <Loading what="the exercise" />;
  if (exercise.loaded.state === "failed") {
    return (
      <>
        <PageTitle document="Exercise">Exercise</PageTitle>
        <ErrorNotice title="The exercise could not be loaded" message={exercise.loaded.error.message} onRetry={exercise.reload} />
      </>
    );
  }
  const value = exercise.loaded.value;
  return (
    <>
      <nav class="trail" aria-label="Where you are"><a href="/exercises">Exercises</a></nav>
      <div class="title-row">
        <PageTitle document={value.title}>{value.title}</PageTitle>
        <Badge tone="neutral">{value.graded ? "Graded: the score shows after release" : "Practice: the score shows at once"}</Badge>
      </div>
      <p class="lead instructions">{value.instructions}</p>
      <div class="columns">
        <Card title="What is asked"><Target exercise={value} /></Card>
        <Card title="How it is scored"><Rubric exercise={value} /></Card>
      </div>
      <Card title="My attempts">
        {attempts.loaded.state === "loading" && <Loading what="attempts" />}
        {attempts.loaded.state === "failed" &&
          <ErrorNotice title="The attempts could not be loaded" message={attempts.loaded.error.message} onRetry={attempts.reload} />}
        {attempts.loaded.state === "ready" && <OwnAttempts attempts={attempts.loaded.value.attempts} graded={value.graded} />}
      </Card>
    </>
  );
}

function Target({ exercise }: { readonly exercise: Exercise }) {
  const { target } = exercise;
  return (
    <dl class="facts stacked">
      <div><dt>Bur</dt><dd>{burText(exercise.bur)}</dd></div>
      <div><dt>Length, mesial to distal</dt><dd>{micrometresAsMm(2 * target.half_size_um[0])}</dd></div>
      <div><dt>Width, buccal to lingual</dt><dd>{micrometresAsMm(2 * target.half_size_um[1])}</dd></div>
      <div><dt>Depth</dt><dd>{micrometresAsMm(target.depth_um)}</dd></div>
      <div><dt>May go beyond the walls</dt><dd>{micrometresAsMm(target.leeway_side_um)}</dd></div>
      <div><dt>May go below the floor</dt><dd>{micrometresAsMm(target.leeway_bottom_um)}</dd></div>
      <div><dt>Must stay</dt><dd>the {micrometresAsMm(target.container_um)} around that</dd></div>
    </dl>
  );
}

function Rubric({ exercise }: { readonly exercise: Exercise }) {
  const { criteria } = exercise.rubric;
  const total = criteria.reduce((sum, criterion) => sum + criterion.points, 0);
  return (
    <TableFrame label="Rubric">
      <table>
        <thead><tr><th scope="col">Criterion</th><th scope="col">Full marks</th><th scope="col">No marks</th><th scope="col" class="number">Points</th></tr></thead>
        <tbody>
          {criteria.map((criterion) => {
            const ends = markEnds(criterion.map);
            return (
              <tr key={criterion.metric}>
                <th scope="row">{criterion.title}</th>
                <td>{ends.full === undefined ? "–" : formatQuantity(ends.full, criterion.unit)}</td>
                <td>{ends.none === undefined ? "–" : formatQuantity(ends.none, criterion.unit)}</td>
                <td class="number">{formatNumber(criterion.points, 1)}</td>
              </tr>
            );
          })}
        </tbody>
        <tfoot><tr><th scope="row" colSpan={3}>Total</th><td class="number">{formatNumber(total, 1)}</td></tr></tfoot>
      </table>
    </TableFrame>
  );
}

// The value nearest to the middle of the marks that still has all of them, and the first with none.
function markEnds(map: ReadonlyArray<{ readonly value: number; readonly share: number }>) {
  const full = map.filter((point) => point.share >= 1);
  const none = map.filter((point) => point.share <= 0);
  const falling = (map.at(0)?.share ?? 0) >= (map.at(-1)?.share ?? 0);
  return falling ? { full: full.at(-1)?.value, none: none.at(0)?.value } : { full: full.at(0)?.value, none: none.at(-1)?.value };
}

function OwnAttempts({ attempts, graded }: { readonly attempts: readonly Attempt[]; readonly graded: boolean }) {
  if (attempts.length === 0) return <Empty>No attempt yet. Sign in at a station and choose this exercise there.</Empty>;
  return (
    <TableFrame label="My attempts at this exercise">
      <table>
        <thead><tr><th scope="col">When</th><th scope="col">State</th><th scope="col" class="number">Score</th><th scope="col">Flags</th></tr></thead>
        <tbody>
          {attempts.map((attempt) => (
            <tr key={attempt.id}>
              <th scope="row"><a href={`/attempts/${attempt.id}`}>{formatDateTime(attempt.ticketed_ms)}</a></th>
              <td><StateBadge attempt={attempt} /></td>
              <td class="number score-cell">{formatScore(attempt.score)}</td>
              <td><Flags attempt={attempt} graded={graded} /></td>
            </tr>
          ))}
        </tbody>
      </table>
    </TableFrame>
  );
}
