import type { Json } from "../base/document";
import { ok } from "../base/result";
import { type ApiResult, type Http, segment, type Tagged, tagOf } from "./http";
import type {
  Annotation,
  Assignment,
  AssignmentInsight,
  AssignmentMove,
  AssignmentTerms,
  AttemptDetail,
  CohortGrades,
  Exercise,
  ExerciseState,
  ExerciseSummary,
  ExerciseVersion,
  Grading,
  Reference,
  Remark,
  RubricPreview,
  RubricVersion,
  SavedText,
  ScoringMetric,
  ResultRun,
  SharingEdit,
  TextToSave,
} from "./types";

type Seen = Pick<AttemptDetail, "id" | "revision">;

// Exercises, assignments, and what is said about attempts.
export class TeachingApi {
  constructor(private readonly http: Http) {}

  // The caller's own exercises; for people who edit exercises, the newest of each name in a state.
  exercises(state?: ExerciseState, signal?: AbortSignal) {
    return this.http.all<ExerciseSummary>("/exercises", "exercises", { state }, signal);
  }
  exercise(id: string, signal?: AbortSignal) {
    return this.http.tagged<Exercise>("GET", exercisePath(id), { signal });
  }
  versions(id: string, signal?: AbortSignal) {
    return this.http.all<ExerciseVersion>(`${exercisePath(id)}/versions`, "versions", {}, signal);
  }
  references(id: string, signal?: AbortSignal) {
    return this.http.all<Reference>(`${exercisePath(id)}/references`, "references", {}, signal);
  }
  withdrawReference(id: string) {
    return this.http.empty("POST", `/references/${segment(id)}/withdraw`);
  }
  documentAddress(id: string): string {
    return `/api/v1${exercisePath(id)}/document`;
  }
  initialSurface(id: string, signal?: AbortSignal): Promise<ApiResult<ArrayBuffer>> {
    return this.http.bytes(`${exercisePath(id)}/initial-surface`, signal);
  }
  document(id: string, signal?: AbortSignal) {
    return this.http.json<Json>("GET", `${exercisePath(id)}/document`, { signal });
  }
  // Everything that a rubric can judge.
  async metrics(signal?: AbortSignal): Promise<ApiResult<readonly ScoringMetric[]>> {
    const result = await this.http.json<{ readonly metrics: readonly ScoringMetric[] }>("GET", "/scoring-metrics", {
      signal,
    });
    return result.ok ? ok(result.value.metrics) : result;
  }
  // Every rubric that counted, the newest first; its tag goes with a correction of it.
  async rubrics(id: string, signal?: AbortSignal): Promise<ApiResult<Tagged<readonly RubricVersion[]>>> {
    const result = await this.http.tagged<{ readonly rubrics: readonly RubricVersion[] }>(
      "GET",
      `${exercisePath(id)}/rubrics`,
      { signal },
    );
    return result.ok ? ok({ value: result.value.value.rubrics, tag: result.value.tag }) : result;
  }
  previewRubric(id: string, rubric: Json) {
    return this.http.json<RubricPreview>("POST", `${exercisePath(id)}/rubrics/preview`, { body: rubric });
  }
  // Checks a document while it is typed.
  checkRubric(id: string, text: string, signal?: AbortSignal) {
    return this.http.json<RubricPreview>("POST", `${exercisePath(id)}/rubrics/preview?attempts=false`, {
      body: text,
      type: "application/json",
      signal,
    });
  }
  // `anyway`: as of makeReference.
  publishRubric(id: string, rubric: Json, reason: string, anyway: string, tag: string) {
    return this.http.json<RubricVersion>("POST", `${exercisePath(id)}/rubrics`, {
      body: { reason, rubric, ...(anyway === "" ? {} : { anyway }) },
      tag,
    });
  }
  checkExercise(text: string, signal?: AbortSignal) {
    return this.http.json<{ readonly warnings: readonly string[] }>("POST", "/exercises?dry_run=true", {
      body: text,
      type: "application/json",
      signal,
    });
  }
  // `text`: an exercise document (schemas/exercise.schema.json), sent unchanged.
  putDraft(text: string) {
    return this.http.json<Exercise>("POST", "/exercises", { body: text, type: "application/json" });
  }
  replaceDraft(id: string, text: string, tag: string) {
    return this.http.json<Exercise>("PUT", exercisePath(id), { body: text, type: "application/json", tag });
  }
  deleteDraft(id: string, tag: string) {
    return this.http.empty("DELETE", exercisePath(id), { tag });
  }
  publish(id: string, tag: string) {
    return this.http.json<Exercise>("POST", `${exercisePath(id)}/publish`, { tag });
  }
  retire(id: string) {
    return this.http.empty("POST", `${exercisePath(id)}/retire`);
  }
  // Whose it is, and whether other instructors may use it.
  share(id: string, edit: SharingEdit) {
    return this.http.json<Exercise>("PUT", `${exercisePath(id)}/sharing`, { body: edit });
  }

  // In the order in which they are due.
  assignments(query: { readonly cohort?: string | undefined }, signal?: AbortSignal) {
    return this.http.all<Assignment>("/assignments", "assignments", { ...query }, signal);
  }
  assignment(id: string, signal?: AbortSignal) {
    return this.http.tagged<Assignment>("GET", assignmentPath(id), { signal });
  }
  assign(terms: AssignmentTerms) {
    return this.http.json<Assignment>("POST", "/assignments", { body: terms });
  }
  editAssignment(id: string, terms: AssignmentTerms, tag: string) {
    return this.http.tagged<Assignment>("PUT", assignmentPath(id), { body: terms, tag });
  }
  // What moving it to another version of its exercise would do, and doing it.
  lookAtMove(id: string, version: string, signal?: AbortSignal) {
    return this.http.json<AssignmentMove>("POST", `${assignmentPath(id)}/move?dry_run=true`, {
      body: { exercise_id: version },
      signal,
    });
  }
  moveAssignment(id: string, version: string, tag: string) {
    return this.http.tagged<AssignmentMove>("POST", `${assignmentPath(id)}/move`, {
      body: { exercise_id: version },
      tag,
    });
  }
  // One result for each student and assignment of a cohort.
  grades(cohort: string, signal?: AbortSignal) {
    return this.http.json<CohortGrades>("GET", `/cohorts/${segment(cohort)}/grades`, { signal });
  }
  // Its attempts with the points lost by criterion, all of them at once.
  grading(of: { readonly assignment: string } | { readonly cohort: string }, signal?: AbortSignal) {
    const path = "assignment" in of ? assignmentPath(of.assignment) : `/cohorts/${segment(of.cohort)}`;
    return this.http.json<Grading>("GET", `${path}/grading`, { signal });
  }
  // How the class did under one assignment.
  insight(id: string, signal?: AbortSignal) {
    return this.http.json<AssignmentInsight>("GET", `${assignmentPath(id)}/insight`, { signal });
  }
  // Files for spreadsheets.
  gradesFile(cohort: string): string {
    return `/api/v1/cohorts/${segment(cohort)}/grades.csv`;
  }
  attemptsFile(cohort: string): string {
    return `/api/v1/cohorts/${segment(cohort)}/attempts.csv`;
  }
  deleteAssignment(id: string, tag: string) {
    return this.http.empty("DELETE", assignmentPath(id), { tag });
  }
  // How many scores were not released before.
  releaseAssignment(id: string) {
    return this.http.json<{ released: number }>("POST", `${assignmentPath(id)}/release`);
  }

  // What is said about an attempt is said about it as it was seen (its revision).
  release({ id, revision }: Seen) {
    return this.http.empty("POST", `${attemptPath(id)}/release`, { tag: tagOf(revision) });
  }
  withdrawRelease({ id, revision }: Seen) {
    return this.http.empty("DELETE", `${attemptPath(id)}/release`, { tag: tagOf(revision) });
  }
  override({ id, revision }: Seen, score: number, reason: string) {
    return this.http.json<AttemptDetail>("PUT", `${attemptPath(id)}/override`, {
      body: { score, reason },
      tag: tagOf(revision),
    });
  }
  dropOverride({ id, revision }: Seen) {
    return this.http.json<AttemptDetail>("DELETE", `${attemptPath(id)}/override`, { tag: tagOf(revision) });
  }
  rescore(attempt: string) {
    return this.http.json<AttemptDetail>("POST", `${attemptPath(attempt)}/rescore`);
  }
  excuse({ id, revision }: Seen, reason: string) {
    return this.http.json<AttemptDetail>("POST", `${attemptPath(id)}/excuse`, {
      body: { reason },
      tag: tagOf(revision),
    });
  }
  takeExcuseBack({ id, revision }: Seen) {
    return this.http.json<AttemptDetail>("DELETE", `${attemptPath(id)}/excuse`, { tag: tagOf(revision) });
  }
  // The score of an earlier run (results) counts again.
  restoreResult({ id, revision }: Seen, run: number) {
    return this.http.json<AttemptDetail>("POST", `${attemptPath(id)}/restore-result`, {
      body: { run },
      tag: tagOf(revision),
    });
  }
  // `anyway`: why, where it was refused with that field; else empty.
  makeReference(attempt: string, dentist: string, consent: boolean, anyway: string) {
    return this.http.json<Reference>("POST", `${attemptPath(attempt)}/reference`, {
      body: { dentist, consent, ...(anyway === "" ? {} : { anyway }) },
    });
  }
  results(attempt: string, signal?: AbortSignal) {
    return this.http.all<ResultRun>(`${attemptPath(attempt)}/results`, "results", {}, signal);
  }

  annotations(attempt: string, signal?: AbortSignal) {
    return this.http.all<Annotation>(`${attemptPath(attempt)}/annotations`, "annotations", {}, signal);
  }
  annotate(attempt: string, remark: Remark) {
    return this.http.json<Annotation>("POST", `${attemptPath(attempt)}/annotations`, { body: remark });
  }
  editAnnotation({ id, revision }: Annotation, remark: Remark) {
    return this.http.json<Annotation>("PUT", `/annotations/${segment(id)}`, { body: remark, tag: tagOf(revision) });
  }
  deleteAnnotation({ id, revision }: Annotation) {
    return this.http.empty("DELETE", `/annotations/${segment(id)}`, { tag: tagOf(revision) });
  }

  savedTexts(signal?: AbortSignal) {
    return this.http.all<SavedText>("/saved-texts", "texts", {}, signal);
  }
  saveText(text: TextToSave) {
    return this.http.json<SavedText>("POST", "/saved-texts", { body: text });
  }
  replaceText({ id, revision }: SavedText, text: TextToSave) {
    return this.http.json<SavedText>("PUT", `/saved-texts/${segment(id)}`, { body: text, tag: tagOf(revision) });
  }
  removeText({ id, revision }: SavedText) {
    return this.http.empty("DELETE", `/saved-texts/${segment(id)}`, { tag: tagOf(revision) });
  }

  fileAppeal(attempt: string, text: string) {
    return this.http.json<AttemptDetail>("POST", `${attemptPath(attempt)}/appeal`, { body: { text } });
  }
  answerAppeal(attempt: string, outcome: "regrade" | "reject", answer: string) {
    return this.http.json<AttemptDetail>("POST", `${attemptPath(attempt)}/appeal/answer`, {
      body: { outcome, answer },
    });
  }
}

function exercisePath(id: string): string {
  return `/exercises/${segment(id)}`;
}

function assignmentPath(id: string): string {
  return `/assignments/${segment(id)}`;
}

function attemptPath(id: string): string {
  return `/attempts/${segment(id)}`;
}
