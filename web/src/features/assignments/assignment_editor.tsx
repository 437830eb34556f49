import { useState } from "preact/hooks";
import { exerciseTitle } from "../../api/builtin_words";
import type { Client } from "../../api/client";
import type { Assignment, ExerciseSummary } from "../../api/types";
import { useChange } from "../../api/use_change";
import { useRequest } from "../../api/use_request";
import { say } from "../../base/words";
import { ErrorNotice, Loading } from "../../widgets/basics";
import { Dialog, FormButtons } from "../../widgets/dialog";
import { SelectField } from "../../widgets/form";
import { fitting, type Terms, TermsFields } from "./terms_fields";

interface Props {
  readonly client: Client;
  readonly cohort: string; // chosen to begin with; empty: none
  readonly onClose: () => void;
  readonly onMade: (made: Assignment) => void;
}

const kTerms: Terms = {
  opens_ms: 0,
  due_ms: 0,
  attempt_limit: 0,
  exam: false,
  late_allowed: false,
  sign_off: false,
  hands: "listed",
  outline: "practice",
  counting: "best",
  station_ids: [],
};

// A new assignment: an exercise for a cohort, with its terms.
export function AssignmentEditor({ client, cohort, onClose, onMade }: Props) {
  const exercises = useRequest("exercises", (signal) => client.all("/exercises", { state: "published", signal }));
  const cohorts = useRequest("cohorts", (signal) => client.all("/cohorts", { signal }));
  const stations = useRequest("stations", (signal) => client.all("/stations", { signal }));
  const failed = [exercises.loaded, cohorts.loaded, stations.loaded].find((loaded) => loaded.state === "failed");
  return (
    <Dialog title={say("assign.title")} onClose={onClose} wide>
      {failed?.state === "failed" && <ErrorNotice title={say("assign.failed")} message={failed.error.message} />}
      {exercises.loaded.state === "ready" && cohorts.loaded.state === "ready" && stations.loaded.state === "ready" ? (
        <Fields
          client={client}
          cohort={cohort}
          onClose={onClose}
          onMade={onMade}
          exercises={exercises.loaded.value.filter(({ may }) => may.includes("assign")).map(assignable)}
          cohorts={cohorts.loaded.value.map(({ id, name }) => ({ value: id, title: name }))}
          stations={stations.loaded.value.filter((station) => !station.revoked)}
        />
      ) : (
        failed === undefined && <Loading what={say("loading.assignable")} />
      )}
    </Dialog>
  );
}

// Graded work without a reference is refused by the server, with what to do.
function assignable({ name, title, graded, has_reference }: ExerciseSummary) {
  const shown = exerciseTitle({ title, graded });
  return { value: name, title: graded && !has_reference ? say("assign.no_reference", { title: shown }) : shown };
}

interface FieldsProps extends Props {
  readonly exercises: ReadonlyArray<{ readonly value: string; readonly title: string }>;
  readonly cohorts: ReadonlyArray<{ readonly value: string; readonly title: string }>;
  readonly stations: ReadonlyArray<{ readonly id: string; readonly name: string }>;
}

function Fields({ client, cohort, onClose, onMade, exercises, cohorts, stations }: FieldsProps) {
  const [exercise, setExercise] = useState(exercises[0]?.value ?? "");
  const [into, setInto] = useState(cohort !== "" ? cohort : (cohorts[0]?.value ?? ""));
  const [terms, setTerms] = useState(kTerms);
  const change = useChange();
  const submit = async (event: Event) => {
    event.preventDefault();
    const result = await change.run(() =>
      client.post("/assignments", { body: { exercise, cohort_id: into, ...fitting(terms) } }),
    );
    if (result?.ok === true) onMade(result.value);
  };
  const problemOf = (field: string) => (change.error?.field === field ? change.error.message : undefined);
  return (
    <form class="form" onSubmit={(event) => void submit(event)}>
      <div class="form-grid">
        <SelectField
          label={say("common.exercise")}
          value={exercise}
          onValue={setExercise}
          options={exercises}
          problem={problemOf("exercise")}
        />
        <SelectField
          label={say("common.cohort")}
          value={into}
          onValue={setInto}
          options={cohorts}
          problem={problemOf("cohort_id")}
        />
      </div>
      <TermsFields
        terms={terms}
        onTerms={(part) => setTerms((now) => ({ ...now, ...part }))}
        stations={stations}
        problemOf={problemOf}
      />
      {change.error !== undefined &&
        !["exercise", "cohort_id", "due_ms", "opens_ms", "attempt_limit"].includes(change.error.field) && (
          <ErrorNotice title={say("assign.not_assigned")} message={change.error.message} />
        )}
      <FormButtons
        action={say("assign.assign")}
        busy={change.busy}
        blocked={exercise === "" ? say("assign.no_exercise") : into === "" ? say("assign.no_cohort") : undefined}
        onCancel={onClose}
      />
    </form>
  );
}
