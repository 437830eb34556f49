// Exercises, assignments and grades of the mock server: what their routes do beyond the contract.
import { conflict, documentSchema, golden, invalid, problemOf, Reply } from "./contract.mjs";
import { hidden } from "./mock_attempts.mjs";
import { scoreOf } from "./mock_exercises.mjs";
import { toothSurface } from "./mock_tooth.mjs";
import { added } from "./mock_world.mjs";

const teaches = ({ role }) => role !== "student";

export function exerciseView(row, { world, person }) {
  const owns = person.role === "admin" || row.owner === person;
  const may = [...(owns ? ["change"] : []), ...(row.state === "published" && (owns || row.shared) ? ["assign"] : [])];
  return {
    ...row,
    owner: teaches(person) ? row.owner : null,
    may: teaches(person) ? may : [],
    my_attempts: world.attempts.filter((each) => each.exercise === row && each.person === person).length,
  };
}

export function assignmentView(row, { world, person, session }) {
  const [newest] = published(world, row.exercise);
  const version = row.version ?? newest;
  const made = madeUnder(world, row, person);
  const grade = gradeOf(made.filter((each) => !hidden(each)));
  return {
    ...row,
    exercise: {
      name: row.exercise,
      id: version?.id ?? null,
      title: version?.title ?? null,
      version: version?.version ?? 0,
      newest_id: newest?.id ?? null,
      newest_version: newest?.version ?? null,
    },
    mine:
      session === undefined || teaches(person)
        ? null
        : {
            attempts_used: made.length,
            attempts_left: row.attempt_limit === 0 ? null : Math.max(0, row.attempt_limit - made.length),
            refusal: row.opens_ms > world.nowMs ? "This exam is not open yet." : "",
            grade,
          },
  };
}

const published = (world, name) =>
  world.exercises.filter((row) => row.name === name && row.state === "published").sort((a, b) => b.version - a.version);

// Of several attempts the best counts.
function gradeOf(attempts) {
  const scored = attempts.filter(({ score }) => score !== null).sort((a, b) => b.score - a.score);
  return {
    attempts: attempts.length,
    counted: scored.length,
    score: scored[0]?.score ?? null,
    attempt_id: scored[0]?.id ?? null,
    released: scored.length > 0 && scored.every((row) => !hidden(row)),
  };
}

// Exercises and their rubrics

const kSchemas = {
  exercise: documentSchema("exercise"),
  rubric: documentSchema("rubric"),
};
const kDocument = golden("scene_exercise_gates"),
  kFilled = golden("scene_exercise_restoration");

// What the schemas cannot say of a document.
function wrongDocument(kind, body) {
  const problem = problemOf(kSchemas[kind], body);
  if (problem !== undefined) return invalid(problem.field, problem.message);
  const { criteria } = kind === "exercise" ? body.rubric : body;
  return criteria.some(({ points }) => points > 0)
    ? undefined
    : invalid(
        kind === "exercise" ? "rubric.criteria" : "criteria",
        "rubric: no criterion gives points, so there is no score",
      );
}

// Kept after the first request, so that a saved draft reads as it was saved.
function documentOf({ documents }, { id, name, title, instructions, graded, version, revision, target }) {
  const document = name.startsWith("class-2") ? kFilled : kDocument;
  if (!documents.has(id))
    documents.set(id, {
      ...document,
      target: { ...document.target, landmark: target.landmark },
      name,
      title,
      instructions,
      graded,
      time_limit_s: 600 + 60 * ((version || revision) - 1),
    });
  return documents.get(id);
}

function rubricsOf({ world, row }) {
  const { rubrics } = world;
  if (!rubrics.has(row.id))
    rubrics.set(row.id, [
      { version: 1, published_ms: row.published_ms, document: { enamel_rubric: 1, ...documentOf(world, row).rubric } },
    ]);
  return rubrics.get(row.id);
}

// The revision that If-Match names.
export const tagOf = (call) =>
  call.operation.path.endsWith("/rubrics") ? rubricsOf(call)[0].version : call.row.revision;

function keepDraft({ world, person, rows, row, body, query }) {
  const wrong = wrongDocument("exercise", body);
  if (wrong !== undefined) return wrong;
  if (query.dry_run) return new Reply({ warnings: [] }, { status: 200 });
  const { name, title, instructions, graded, time_limit_s } = body;
  const admin = person.role === "admin";
  const draft = Object.assign(
    row ??
      added(world, rows, {
        ...world.exercises[0],
        state: "draft",
        version: 0,
        has_reference: false,
        owner: admin ? null : person,
        shared: admin,
      }),
    { name, title, instructions, graded, time_limit_s },
  );
  world.documents.set(draft.id, body);
  return draft;
}

function beginTrial({ world, rows, body }) {
  const wrong = wrongDocument("exercise", body);
  if (wrong !== undefined) return wrong;
  const none = { exact: null, untouched: null, problem: null };
  return added(world, rows, {
    state: "waiting",
    ahead: 1,
    share: 0,
    took_s: 0,
    ...none,
    criteria: body.rubric.criteria,
  });
}

// A first criterion of more than 40 points is the one that is wrong.
function lookAtTrial({ row }) {
  if (row.state === "waiting") return Object.assign(row, { state: "working", ahead: 0, share: 0.4 });
  const { metric, title, points } = row.criteria[0];
  const named = points > 40 ? [{ metric, title, share: 0.25 }] : [];
  return Object.assign(row, {
    state: "done",
    share: 1,
    took_s: 4.2,
    exact: { score: 100 - 60 * named.length, failed: false, critical: [], named },
    untouched: { score: 0, failed: true, critical: ["nothing_cut"], named: [] },
  });
}

function previewRubric({ world, row, body, query }) {
  const wrong = wrongDocument("rubric", body);
  if (wrong !== undefined) return wrong;
  const scored = query.attempts
    ? world.attempts.filter(({ exercise, state }) => exercise === row && state === "scored")
    : [];
  const attempts = scored.map((each) => ({
    ...each,
    attempt_id: each.id,
    before: each.computed_score,
    after: 0.9 * each.computed_score,
  }));
  const histogram_before = tenthsOf(attempts.map(({ before }) => before));
  return {
    attempts,
    lowered: attempts.length,
    mean_before: 70,
    mean_after: 63,
    histogram_before,
    histogram_after: histogram_before,
  };
}

function correctRubric(call) {
  const rubrics = rubricsOf(call);
  const {
    world,
    body: { rubric: document, reason },
  } = call;
  if (JSON.stringify(document) === JSON.stringify(rubrics[0].document))
    return conflict("the current rubric is already the same");
  rubrics.unshift({ version: rubrics[0].version + 1, reason, published_ms: world.nowMs, document });
  return new Reply(rubrics[0], { tag: rubrics[0].version });
}

export const exerciseRules = {
  "GET /exercises": (call) => ({
    exercises: call.rows
      .filter(({ state }) => state === (call.query.state ?? "published"))
      .map((row) => exerciseView(row, call)),
  }),
  "POST /exercises": keepDraft,
  "PUT /exercises/{id}": keepDraft,
  "POST /exercise-trials": beginTrial,
  "GET /exercise-trials/{id}": lookAtTrial,
  "GET /exercises/{id}/document": ({ world, row }) => documentOf(world, row),
  "GET /exercises/{id}/initial-surface": () => new Reply(toothSurface({ whole: true })),
  "GET /exercises/{id}/versions": ({ rows, row }) => ({ versions: rows.filter(({ name }) => name === row.name) }),
  "POST /exercises/{id}/publish": ({ world, row }) =>
    Object.assign(row, { state: "published", version: 1, published_ms: world.nowMs }),
  "POST /exercises/{id}/retire": ({ row }) => void Object.assign(row, { state: "retired", revision: row.revision + 1 }),
  "PUT /exercises/{id}/sharing": ({ row, body: { shared = row.shared } }) => Object.assign(row, { shared }),
  "GET /exercises/{id}/rubrics": (call) => new Reply({ rubrics: rubricsOf(call) }, { tag: rubricsOf(call)[0].version }),
  "POST /exercises/{id}/rubrics": correctRubric,
  "POST /exercises/{id}/rubrics/preview": previewRubric,
  "POST /references/{id}/withdraw": ({ world, row }) => {
    row.withdrawn_ms = world.nowMs;
  },
};

// Assignments

function termsOf({ world, body: { cohort_id: cohort, station_ids: stations = [], ...terms } }) {
  if (terms.sign_off && !terms.exam) return invalid("sign_off", "expected sign-off of an exam only");
  if (terms.due_ms > 0 && terms.due_ms <= terms.opens_ms)
    return invalid("due_ms", "expected due_ms after opens_ms, or 0 for never");
  return {
    hands: "listed",
    counting: "best",
    sign_off: false,
    ...terms,
    cohort: world.cohorts.find(({ id }) => id === cohort) ?? null,
    stations: world.stations.filter(({ id }) => stations.includes(id)),
  };
}

function assign(call) {
  const terms = termsOf(call);
  if (terms instanceof Reply) return terms;
  return call.row === undefined
    ? added(call.world, call.rows, { ...terms, version: published(call.world, terms.exercise)[0] })
    : Object.assign(call.row, terms);
}

function move(call) {
  const { world, row, body, query } = call;
  const to = world.exercises.find(({ id }) => id === body.exercise_id);
  const from = row.version ?? published(world, row.exercise)[0];
  const kept = world.attempts.filter((each) => each.assignment_id === row.id && each.exercise !== to);
  if (!query.dry_run) row.version = to;
  return {
    moved: !query.dry_run,
    from_version: from.version,
    to_version: to.version,
    attempts: kept.length,
    assignment: assignmentView(row, call),
  };
}

const madeUnder = (world, assignment, person) =>
  world.attempts.filter(
    (row) => row.assignment_id === assignment.id && row.person === person && !row.flags.includes("excused"),
  );

function cohortGrades(call) {
  const { world, row } = call;
  const assignments = world.assignments.filter(({ cohort }) => cohort === row || cohort === null);
  const students = row.members
    .filter(({ role }) => role === "student")
    .map((person) => ({ person, grades: assignments.map((each) => gradeOf(madeUnder(world, each, person))) }));
  const summary = { students: students.length, graded: 3, mean: 71.5, median: 70, lowest: 55, highest: 90 };
  return {
    students,
    assignments: assignments.map((each) => ({
      ...assignmentView(each, call),
      everybody: each.cohort === null,
      summary,
    })),
  };
}

const tenthsOf = (percents) =>
  Array.from(
    { length: 10 },
    (_, i) => percents.filter((percent) => Math.min(9, Math.floor(percent / 10)) === i).length,
  );

// How a class did: who has begun, and figures for each criterion.
function insightOf({ world, row }) {
  const members = row.cohort?.members ?? world.people;
  const { criteria } = scoreOf(row);
  const spread = { count: 9, least: 38, lower: 41, median: 55, upper: 70, most: 95 };
  const students = members
    .filter(({ role }) => role === "student")
    .map((person) => {
      const { attempts, score, attempt_id, released } = gradeOf(madeUnder(world, row, person));
      const state = attempts === 0 ? "not_started" : score === null ? "waiting" : "scored";
      return {
        person,
        state,
        attempts,
        score,
        attempt_id,
        released,
        time_s: 42 * attempts,
        points: criteria.map(({ points }) => (state === "scored" ? points : null)),
      };
    });
  const scored = students.filter(({ state }) => state === "scored");
  const not_started = students.filter(({ state }) => state === "not_started").length;
  const judged =
    scored.length === 0
      ? []
      : criteria.map((each, i) => ({
          ...each,
          judged: scored.length,
          half_lost: i,
          mean_points: each.points,
          earned_tenths: [0, 1, 0, 2, 1, 3, 5, 4, 2, 1],
          values: spread,
        }));
  return {
    assignment_id: row.id,
    counting: row.counting,
    criteria: judged,
    commonest: judged[1]?.name ?? null,
    students,
    gates: [{ name: "task_done_percent", title: "Task done", taken: 1 }],
    summary: {
      students: students.length,
      not_started,
      scored: scored.length,
      scores: spread,
      times_s: spread,
      score_tenths: tenthsOf(scored.map(({ score }) => score)),
    },
    outliers: scored
      .slice(0, 1)
      .map(({ person }) => ({ person_id: person.id, what: "time_all_attempts_s", value: 590, median: 55, z: 9.1 })),
    staff: world.attempts
      .filter(
        ({ person, exercise }) =>
          members.includes(person) && person.role !== "student" && exercise.name === row.exercise,
      )
      .map((each) => ({ ...each, attempt_id: each.id, time_s: 42 })),
  };
}

export const assignmentRules = {
  "POST /assignments": assign,
  "PUT /assignments/{id}": assign,
  "POST /assignments/{id}/move": move,
  "POST /assignments/{id}/release": ({ world, row }) => {
    const waiting = world.attempts.filter(
      (each) => each.assignment_id === row.id && each.state === "scored" && !each.released,
    );
    for (const each of waiting) each.released = true;
    return { released: waiting.length };
  },
  "GET /assignments/{id}/insight": insightOf,
  "GET /cohorts/{id}/grades": cohortGrades,
};
