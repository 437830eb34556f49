// One successful call of each operation about exercises, assignments and attempts: see run.mjs.
import assert from "node:assert/strict";
import { until } from "./client.mjs";
import { golden } from "./contract.mjs";

const kDay_ms = 86_400_000;
const later = () => Date.now() + kDay_ms;
const scored = (w, id, run = 1) =>
  until(
    `attempt ${id} is scored`,
    () => w.admin.ask("GET", `/api/v1/attempts/${id}/results`),
    ({ json }) => json?.results?.length >= run,
  );
const settled = (w, id) =>
  until(
    `attempt ${id} has no run waiting`,
    () => w.admin.ask("GET", `/api/v1/attempts/${id}`),
    ({ json }) => json.state === "scored",
  );
// Has the whole cohort scored again.
const again = async (w) => {
  for (const id of [w.scored, w.sues]) await settled(w, id);
  await until(
    "no run waits",
    () => w.ben.need("GET", "/api/v1/batches"),
    ({ json }) => json.batches.every(({ over }) => over),
  );
  return w.ben.need("POST", `/api/v1/cohorts/${w.demo}/rescore`, { body: {} });
};
const made = (w, id) =>
  until(
    `the playback of ${id} is made`,
    () => w.admin.ask("HEAD", `/api/v1/attempts/${id}/timeline`),
    ({ status }) => status === 200,
  );
const draft = async (w, name) => {
  const body = { ...w.document, name, title: name };
  return (await w.ben.need("POST", "/api/v1/exercises", { body })).json;
};
// Published, and assigned to nobody.
const bens = { mine: ["ben"], unassigned: true, at: (w) => w.mine };

export const exercises = [
  { of: "listExercises", by: "sam" },
  { of: "listExercises", by: "ben", hidden: true, query: "?state=published" },
  {
    of: "getExerciseDocument",
    by: "ben",
    at: (w) => w.exercise,
    shared: true,
    after: (w, { json }) => {
      w.document = json;
    },
  },
  {
    of: "putDraft",
    by: "ben",
    query: "?dry_run=true",
    body: (w) => ({ ...w.document, name: "private", title: "Private" }),
  },
  {
    of: "putDraft",
    by: "ben",
    body: (w) => ({ ...w.document, name: "private", title: "Private" }),
    after: (w, { json }) => {
      w.mine = json.id;
    },
  },
  { of: "replaceDraft", by: "ben", ...bens, body: (w) => ({ ...w.document, name: "private", title: "Still private" }) },
  { of: "getExercise", by: "ben", ...bens },
  { of: "publishDraft", by: "ben", ...bens },
  { of: "listExerciseVersions", by: "ben", ...bens },
  { of: "listExerciseVersions", by: "sam", shared: true, at: (w) => w.exercise },
  { of: "getExercise", by: "sam", shared: true, at: (w) => w.exercise },
  { of: "getInitialSurface", by: "sam", shared: true, at: (w) => w.exercise },
  { of: "retireExercise", by: "ben", ...bens, body: () => ({ reason: "A better one is there" }) },
  { of: "offerExerciseAgain", by: "ben", ...bens },
  { of: "shareExercise", by: "ben", ...bens, body: (w) => ({ shared: false, owner_id: w.ben.id }) },
  {
    of: "deleteDraft",
    by: "ben",
    mine: ["ben"],
    before: async (w) => {
      w.draft = (await draft(w, "thrown-away")).id;
    },
    at: (w) => w.draft,
  },
  // A handpiece, and parts of a target: of what is left standing, and as wide as the bur.
  {
    of: "getExercise",
    by: "ben",
    alone: true,
    before: async (w) => {
      const { handpiece, target } = golden("scene_exercise_relief");
      const { landmark } = w.document.target;
      const wide = ({ corners_um, ...part }) =>
        corners_um === undefined ? part : { ...part, corners_um: corners_um.map((at) => at.map((um) => 3 * um)) };
      const parts = target.parts.filter(({ outline }) => outline !== "box").map(wide);
      // What is left standing has regions of its own.
      const [like] = w.document.rubric.prices;
      const kinds = ["table", "axial_wall", "margin", "line_angle"].filter(
        (of) => !w.document.rubric.prices.some((price) => price.of === of),
      );
      const prices = [...w.document.rubric.prices, ...kinds.map((of) => ({ ...like, of }))];
      const rubric = { ...w.document.rubric, prices };
      const body = { ...w.document, name: "of-parts", rubric, handpiece, target: { ...target, landmark, parts } };
      w.ofParts = (await w.ben.need("POST", "/api/v1/exercises", { body })).json.id;
    },
    at: (w) => w.ofParts,
  },
  {
    of: "listScoringMetrics",
    by: "ben",
    after: (w, { json }) => assert.deepEqual(json.metrics.map(({ name }) => name).sort(), [...w.metrics].sort()),
  },
  {
    of: "listRubrics",
    by: "ben",
    ...bens,
    after: (w, { json }) => {
      w.rubric = json.rubrics[0].document;
    },
  },
  { of: "previewRubricChange", by: "ben", ...bens, body: (w) => w.rubric },
  {
    of: "publishRubric",
    by: "ben",
    mine: ["ben"],
    at: (w) => w.mine,
    body: (w) => {
      const rubric = structuredClone(w.rubric);
      rubric.prices[0].points /= 2;
      return { reason: "The first matters less", rubric, anyway: "Asked for" };
    },
  },
  {
    of: "beginExerciseTrial",
    by: "ben",
    body: (w) => ({ ...w.document, name: "private" }),
    after: (w, { json }) => (w.trial = json.id),
  },
  {
    of: "getExerciseTrial",
    by: "ben",
    mine: ["ben"],
    before: (w) =>
      until(
        "the trial is over",
        () => w.ben.ask("GET", `/api/v1/exercise-trials/${w.trial}`),
        ({ json }) => ["done", "failed"].includes(json.state),
      ),
    at: (w) => w.trial,
  },
  { of: "giveUpExerciseTrial", by: "ben", mine: ["ben"], at: (w) => w.trial },
  { of: "listReferences", by: "ben", shared: true, at: (w) => w.exercise },
];

export const assignments = [
  { of: "listAssignments", by: "sam" },
  { of: "listAssignments", by: "ben" },
  {
    of: "addAssignment",
    by: "ben",
    body: (w) => ({
      exercise: w.document.name,
      cohort_id: w.demo,
      opens_ms: 0,
      due_ms: later(),
      attempt_limit: 3,
      exam: true,
      late_allowed: true,
      sign_off: false,
      hands: "any",
      outline: "always",
      counting: "best",
      station_ids: [w.station],
    }),
    after: (w, { json }) => {
      w.extra = json.id;
    },
  },
  { of: "getAssignment", by: "sam", at: (w) => w.extra },
  {
    of: "replaceAssignment",
    by: "ben",
    at: (w) => w.extra,
    body: (w) => ({ exercise: w.document.name, cohort_id: w.demo, due_ms: later(), counting: "mean" }),
  },
  {
    of: "moveAssignment",
    by: "ben",
    at: (w) => w.extra,
    body: (w) => ({ exercise_id: w.exercise }),
    query: "?dry_run=true",
  },
  { of: "moveAssignment", by: "ben", at: (w) => w.extra, tagged: true, body: (w) => ({ exercise_id: w.exercise }) },
  { of: "deleteAssignment", by: "ben", at: (w) => w.extra },
  { of: "getInsight", by: "ben", at: (w) => w.assignment },
  { of: "getAssignmentGrading", by: "ben", at: (w) => w.assignment },
  { of: "getCohortGrades", by: "ben", at: (w) => w.demo },
  { of: "getGradesFile", by: "ben", at: (w) => w.demo },
  { of: "getCohortGrading", by: "ben", at: (w) => w.demo },
  { of: "getAttemptsFile", by: "ben", at: (w) => w.demo },
  {
    of: "findStandard",
    by: "ben",
    at: (w) => w.assignment,
    type: "text/csv",
    body: (w) =>
      `work,criterion,marker,mark\n${w.scored},rating,A,2\n${w.scored},rating,B,3\nborderline,floor_mm,A,4\nborderline,floor_mm,B,5\n`,
  },
];

// While somebody works at the chair.
export const live = [
  { of: "getLive", by: "ben", at: (w) => w.recording },
  { of: "getLiveCut", by: "ben", at: (w) => w.recording },
  { of: "sendLiveRemark", by: "ben", at: (w) => w.recording, body: () => ({ text: "Stop, the wall is thin." }) },
  { of: "listLiveRemarks", by: "ben", at: (w) => w.recording },
];

const read = (of, more) => ({ of, by: "ben", mine: ["sam"], at: (w) => w.scored, ...more });

export const marking = [
  { of: "listAttempts", by: "ben" },
  { of: "listAttempts", by: "sam", query: "?state=scored&limit=1" },
  read("getAttempt"),
  read("getScore", { hidden: true }),
  {
    of: "beginMarking",
    by: "ben",
    at: (w) => w.assignment,
    body: (w) => ({ marker_ids: [w.ben.id, w.bea.id] }),
    after: (w, { json }) => {
      w.marking = json.id;
    },
  },
  { of: "listMarkings", by: "ben", at: (w) => w.assignment },
  {
    of: "getMarking",
    by: "ben",
    at: (w) => w.marking,
    after: (w, { json }) => {
      w.works = json.mine.map(({ id }) => id);
      w.points = Object.fromEntries(json.criteria.map(({ name }) => [name, { points: 0, comment: "Not yet" }]));
    },
  },
  {
    of: "getMarkingTimeline",
    by: "ben",
    mine: ["ben", "bea"],
    before: (w) => made(w, w.scored),
    at: (w) => w.works[0],
  },
  {
    of: "addMark",
    by: "ben",
    mine: ["ben", "bea"],
    at: (w) => w.works[0],
    body: (w) => ({ rating: 3, criteria: w.points }),
  },
  {
    of: "getMarking",
    by: "ben",
    before: async (w) => {
      const mark = (who, id) =>
        who.need("POST", `/api/v1/marking-works/${id}/marks`, { body: { rating: 2, criteria: w.points } });
      for (const id of w.works.slice(1)) await mark(w.ben, id);
      for (const id of w.works) await mark(w.bea, id);
    },
    at: (w) => w.marking,
  },
  {
    of: "setMarkers",
    by: "ben",
    before: async (w) => {
      const body = { marker_ids: [w.ben.id, w.bea.id] };
      w.marking = (await w.ben.need("POST", `/api/v1/assignments/${w.assignment}/markings`, { body })).json.id;
    },
    at: (w) => w.marking,
    body: (w) => ({ marker_ids: [w.ben.id, w.bea.id] }),
  },
  { of: "endMarking", by: "ben", at: (w) => w.marking },
];

export const attempts = [
  { of: "releaseAssignment", by: "ben", at: (w) => w.assignment },
  { of: "listAssignments", by: "sam" },
  read("getAttempt"),
  read("getScore"),
  read("getSignedResult"),
  read("getSurface"),
  {
    ...read("getTimeline"),
    after: (w, { bytes }) => {
      w.startTooth = Buffer.from(bytes.subarray(48, 80)).toString("hex"); // schemas/surface_timeline.md
    },
  },
  read("getTimeline", { headers: { range: "bytes=0-63" }, status: 206 }),
  read("getDeviation"),
  { of: "getStartTooth", by: "sam", at: (w) => w.startTooth },
  read("getSeries"),
  read("getTicks"),
  read("listResults"),
  read("putOverride", { body: () => ({ score: 77, reason: "Seen at the chair" }) }),
  read("getAttempt"),
  read("deleteOverride"),
  read("addAnnotation", {
    body: () => ({ tick: 10, point_um: [0, 0, 0], text: "Look here" }),
    after: (w, { json, headers }) => {
      w.annotation = json.id;
      w.annotationTag = headers.get("etag");
    },
  }),
  {
    of: "replaceAnnotation",
    by: "ben",
    mine: ["ben"],
    at: (w) => w.annotation,
    tag: (w) => w.annotationTag,
    body: () => ({ tick: 12, point_um: null, text: "Look there" }),
    after: (w, { headers }) => {
      w.annotationTag = headers.get("etag");
    },
  },
  {
    of: "addSavedText",
    by: "ben",
    body: () => ({ text: "Too deep.", shared: true }),
    after: (w, { json, headers }) => {
      w.text = json.id;
      w.textTag = headers.get("etag");
    },
  },
  { of: "listSavedTexts", by: "ben" },
  {
    of: "replaceSavedText",
    by: "ben",
    mine: ["ben"],
    at: (w) => w.text,
    tag: (w) => w.textTag,
    body: () => ({ text: "Much too deep." }),
    after: (w, { headers }) => {
      w.textTag = headers.get("etag");
    },
  },
  { of: "deleteSavedText", by: "ben", mine: ["ben"], at: (w) => w.text, tag: (w) => w.textTag },
  read("releaseAttempt"),
  read("listAnnotations"),
  { of: "deleteAnnotation", by: "ben", mine: ["ben"], at: (w) => w.annotation, tag: (w) => w.annotationTag },
  {
    of: "fileAppeal",
    by: "sam",
    mine: ["sam"],
    at: (w) => w.scored,
    body: () => ({ text: "The wall was there before" }),
  },
  read("answerAppeal", { body: () => ({ outcome: "reject", answer: "It was not" }) }),
  read("excuse", { body: () => ({ reason: "The power failed" }) }),
  read("takeExcuseBack"),
  read("rescore"),
  read("restoreResult", {
    before: async (w) => {
      await scored(w, w.scored, 2);
      await settled(w, w.scored);
    },
    body: () => ({ run: 1 }),
  }),
  read("releaseAttempt"),
  read("withdrawRelease"),
  {
    of: "rescoreCohort",
    by: "ben",
    at: (w) => w.demo,
    body: (w) => ({ exercise_id: w.exercise }),
    after: (w, { json }) => {
      w.batch = json.id;
    },
  },
  { of: "listBatches", by: "ben" },
  { of: "getBatch", by: "ben", at: (w) => w.batch },
  // Each right after its runs were asked for: a run takes longer than the few requests of a step.
  {
    of: "cancelJob",
    by: "admin",
    before: async (w) => {
      await again(w);
      w.job = (await w.admin.need("GET", "/api/v1/jobs?state=queued")).json.jobs[0].id;
    },
    at: (w) => w.job,
  },
  {
    of: "cancelBatch",
    by: "ben",
    before: async (w) => {
      w.batch = (await again(w)).json.id;
    },
    at: (w) => w.batch,
  },
  { of: "listJobs", by: "admin" },
  read("makeReference", {
    before: (w) => settled(w, w.scored),
    body: () => ({ dentist: "Dr. Vega", consent: true, anyway: "Shown as what not to do" }),
    after: (w, { json }) => {
      w.reference = json.id;
    },
  }),
  { of: "listReferences", by: "sam", shared: true, at: (w) => w.exercise },
  { of: "previewRubricChange", by: "admin", alone: true, at: (w) => w.exercise, body: (w) => w.rubric },
  // Compared with two references, what was cut before is scored again.
  {
    of: "getScore",
    by: "ben",
    mine: ["sue"],
    before: async (w) => {
      await settled(w, w.sues);
      const { json } = await w.ben.need("GET", `/api/v1/attempts/${w.sues}/results`);
      await w.ben.need("POST", `/api/v1/attempts/${w.sues}/rescore`);
      await scored(w, w.sues, json.results.length + 1);
      await w.ben.ask("POST", `/api/v1/assignments/${w.assignment}/release`);
    },
    at: (w) => w.sues,
  },
  { of: "withdrawReference", by: "ben", at: (w) => w.reference },
];
