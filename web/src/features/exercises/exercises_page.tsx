import type { Client } from "../../api/client";
import type { Bur, ExerciseSummary } from "../../api/types";
import { useRequest } from "../../api/use_request";
import { micrometresAsMm } from "../../base/format";
import { Badge, Empty, ErrorNotice, Loading, PageTitle } from "../../widgets/basics";

export function ExercisesPage({ client }: { readonly client: Client }) {
  const { loaded, reload } = useRequest("exercises", (signal) => client.exercises(signal));
  return (
    <>
      <PageTitle document="Exercises">Exercises</PageTitle>
      {loaded.state === "loading" && <Loading what="exercises" />}
      {loaded.state === "failed" && <ErrorNotice title="The exercises could not be loaded" message={loaded.error.message} onRetry={reload} />}
      {loaded.state === "ready" && loaded.value.exercises.length === 0 &&
        <Empty>No exercise is assigned to you yet. Your instructor adds them to your cohort.</Empty>}
      {loaded.state === "ready" && (
        <ul class="card-list">
          {loaded.value.exercises.map((exercise) => <li key={exercise.id}><ExerciseCard exercise={exercise} /></li>)}
        </ul>
      )}
    </>
  );
}

function ExerciseCard({ exercise }: { readonly exercise: ExerciseSummary }) {
  return (
    <article class="card exercise">
      <div class="card-head">
        <h2><a href={`/exercises/${exercise.id}`}>{exercise.title}</a></h2>
        <Badge tone="neutral">{exercise.graded ? "Graded" : "Practice"}</Badge>
      </div>
      <p class="instructions">{exercise.instructions}</p>
      <dl class="facts">
        <div><dt>Bur</dt><dd>{burText(exercise.bur)}</dd></div>
        <div><dt>My attempts</dt><dd>{exercise.my_attempts}</dd></div>
        <div><dt>Reference</dt><dd>{exercise.has_reference ? "Available" : "None yet"}</dd></div>
      </dl>
    </article>
  );
}

export function burText(bur: Bur): string {
  const diameter = micrometresAsMm(2 * bur.radius_um);
  if (bur.shape === "sphere") return `Round, ${diameter} across`;
  return `Cylinder, ${diameter} across, ${micrometresAsMm(bur.length_um)} long`;
}
