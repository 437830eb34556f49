// What the contract does not say about the mock server's routes: permissions, effects, computed
// values. A rule gets a call (session, row, query and body) and returns the value of the answer.
import { randomBytes } from "node:crypto";
import { conflict, documentSchema, forbidden, golden, invalid, problemOf, refused, Reply } from "./contract.mjs";
import { attemptRules, attemptView, hidden } from "./mock_attempts.mjs";
import { toothSurface } from "./mock_tooth.mjs";
import { added, criteriaOf, newId, scoreOf } from "./mock_world.mjs";

const teaches = ({ role }) => role !== "student";
const kAdmins =
  /^(\w+ \/(people|roster|audit|health|jobs|builtin-teeth|tooth-imports|enrolment-codes)|(POST|PATCH|DELETE) \/(cohorts|stations|listed-devices|profiles))/;
const kStaff =
  /^(\w+ \/(cohorts|stations|listed-devices|live|profile-reports|scoring-metrics|references|annotations)|(POST|PUT|DELETE) \/(exercises|assignments|attempts)|GET \/profiles\/.*(versions|reports|calibrations)|GET .*\/(live|insight|rubrics))/;

export function mayCall({ route }, { role }) {
  if (route === "POST /attempts/{id}/appeal") return true;
  return kAdmins.test(route) ? role === "admin" : kStaff.test(route) ? role !== "student" : true;
}

// Whether the password has to have been given lately.
export function confirmed({ operation: { route }, query }) {
  if (route === "POST /roster") return !query.dry_run;
  return [
    "POST /people",
    "POST /people/{id}/password",
    "POST /people/{id}/erase",
    "POST /stations/{id}/revoke",
    "POST /enrolment-codes",
  ].includes(route);
}

export const visible = {
  attempts: (row, { person }) => teaches(person) || row.person === person,
  exercises: (row, { person }) => teaches(person) || row.state === "published",
  cohorts: (row, { person }) => person.role === "admin" || row.members.includes(person),
  assignments: ({ cohort }, { person }) =>
    cohort === null || person.role === "admin" || cohort.members.includes(person),
  sessions: (row, { person }) => row.person === person || person.role === "admin",
};

const inCohort = (person, cohort, { world }) =>
  world.cohorts.find((row) => row.id === cohort)?.members.includes(person) ?? false;

// Filters that need more than a comparison with the row.
export const filters = {
  people: {
    cohort: inCohort,
    text: ({ login, display_name }, text) =>
      login.includes(text) || display_name.toLowerCase().includes(text.toLowerCase()),
  },
  cohorts: { archived: ({ archived_ms }, archived) => archived_ms > 0 === archived },
  attempts: {
    cohort: (row, cohort, call) => inCohort(row.person, cohort, call),
    flag: ({ flags }, flag) => flags.includes(flag),
    appeal: ({ appeal }, state) => appeal?.state === state,
  },
  audit: {
    actor: ({ person }, actor) => person?.id === actor,
    action: ({ action }, asked) => action === asked || (asked.endsWith(".") && action.startsWith(asked)),
    from_ms: ({ at_ms }, from) => at_ms >= from,
    until_ms: ({ at_ms }, until) => at_ms <= until,
  },
};

// Rows with their computed members, for the person who asks.
export const views = {
  people: (row, { world }) => ({ ...row, cohorts: world.cohorts.filter(({ members }) => members.includes(row)) }),
  sessions: (row, { session }) => ({
    ...row,
    current: row === session,
    last_used_ms: row.created_ms,
    expires_ms: row.created_ms + 43_200_000,
  }),
  annotations: (row, { person }) => ({ ...row, mine: row.author === person }),
  exercises: (row, { world, person }) => {
    const owns = person.role === "admin" || row.owner === person;
    const may = [...(owns ? ["change"] : []), ...(row.state === "published" && (owns || row.shared) ? ["assign"] : [])];
    return {
      ...row,
      owner: teaches(person) ? row.owner : null,
      may: teaches(person) ? may : [],
      my_attempts: world.attempts.filter((each) => each.exercise === row && each.person === person).length,
    };
  },
  assignments: (row, { world, person, session }) => {
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
  },
  attempts: attemptView,
};

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

// People and sessions

const sessionOf = ({ person, csrf, confirmedMs }) => ({
  person,
  csrf,
  must_change_password: person.must_change_password,
  language: person.language ?? "",
  confirmed_until_ms: confirmedMs + 5 * 60_000,
});

function signIn({ world, body }) {
  const person = world.people.find(
    ({ login, password, disabled }) => login === body.login && password === body.password && !disabled,
  );
  if (person === undefined) return refused(401, "unauthenticated", "Login and password do not match.");
  const [token, csrf] = [randomBytes(32).toString("hex"), randomBytes(16).toString("hex")];
  const session = added(world, world.sessions, {
    person,
    token,
    csrf,
    via: "page",
    address: "127.0.0.1",
    device: "Chrome on Linux",
    confirmedMs: world.nowMs,
  });
  return new Reply(sessionOf(session), {
    headers: { "Set-Cookie": `enamel_session=${token}; HttpOnly; SameSite=Strict; Path=/` },
  });
}

function changePassword({ world, session, person, body }) {
  if (body.old_password !== person.password) return forbidden("That is not your password.", "old_password");
  Object.assign(person, { password: body.new_password, must_change_password: false });
  world.sessions = world.sessions.filter((other) => other.person !== person || other === session);
  return sessionOf(session);
}

const withPassword = ({ world }, person, password) => ({
  ...Object.assign(person, { password, must_change_password: true }),
  password_until_ms: world.nowMs + 7 * 86_400_000,
});

function addPerson(call) {
  const { world, body, rows } = call;
  if (!/^[a-z0-9._-]+$/.test(body.login))
    return invalid("login", "expected letters a-z, digits, dot, minus or underscore");
  if (rows.some(({ login }) => login === body.login)) return conflict("expected a login that nobody has", "login");
  return withPassword(call, added(world, rows, { disabled: false, ...body }), "quiet river lamp");
}

function makeFirstAdmin({ world, rows = world.people, body }) {
  if (body.token !== world.firstAdminToken) return forbidden("This link is not good any more.", "token");
  if (body.password.length < 12) return invalid("password", "this password is easy to guess");
  world.firstAdminToken = undefined;
  return added(world, rows, { ...body, role: "admin", disabled: false, must_change_password: false });
}

function importRoster({ world, query, bytes }) {
  const [header, ...lines] = bytes
    .toString()
    .trim()
    .split("\n")
    .map((line) => line.split(","));
  const rows = lines.map((cells, i) => ({
    row: i + 2,
    ...Object.fromEntries(cells.map((cell, column) => [header[column], cell])),
  }));
  const problems = rows.flatMap(({ row, role, display_name: name }) => [
    ...(["student", "instructor", "admin"].includes(role)
      ? []
      : [{ row, column: "role", found: role, expected: "student, instructor or admin" }]),
    ...(!/^[=+@-]/.test(name)
      ? []
      : [{ row, column: "display_name", found: name, expected: "a name that no spreadsheet takes for a formula" }]),
  ]);
  const people = rows.map((row) => ({
    ...row,
    change: world.people.some(({ login }) => login === row.login) ? "unchanged" : "create",
  }));
  const made = people.filter(({ change }) => change === "create");
  const done = !query.dry_run && problems.length === 0;
  const report = {
    done,
    created: made.length,
    unchanged: rows.length - made.length,
    problem_count: problems.length,
    problems,
    people,
  };
  if (problems.length > 0) return invalid("body", "expected a roster without problems", report);
  const passwords = made.map((row, i) => ({ ...row, password: `copper lantern ${i + 1}` }));
  if (done) for (const row of passwords) added(world, world.people, { ...row, must_change_password: true });
  return { ...report, passwords: done ? passwords : [] };
}

function erase({ world, row, body, rows }) {
  if (body.login !== row.login) return invalid("login", "expected the person's login, because this cannot be undone");
  rows.splice(rows.indexOf(row), 1);
  for (const cohort of world.cohorts) cohort.members = cohort.members.filter((member) => member !== row);
  return { attempts: 2, blobs: 4 };
}

function changeMembers({ world, row, body: { add = [], remove = [] } }) {
  row.members = [
    ...new Set([...row.members, ...add.map((id) => world.people.find((person) => person.id === id))]),
  ].filter(({ id }) => !remove.includes(id));
  row.revision += 1;
  return row;
}

const peopleRules = {
  "POST /session": signIn,
  "GET /session": ({ session }) => sessionOf(session),
  "DELETE /session": ({ world, session }) => {
    world.sessions = world.sessions.filter((other) => other !== session);
  },
  "POST /session/password": changePassword,
  "PUT /session/language": ({ session, person, body }) =>
    sessionOf(Object.assign(session, { person: Object.assign(person, body) })),
  "POST /session/confirm": ({ world, session, person, body }) => {
    if (body.password !== person.password) return forbidden("This is not the password.", "password");
    session.confirmedMs = world.nowMs;
    return undefined;
  },
  "GET /sessions": ({ world, person, session }) => ({
    sessions: world.sessions.filter((row) => row.person === person).map((row) => views.sessions(row, { session })),
  }),
  "POST /first-admin": makeFirstAdmin,
  "POST /people": addPerson,
  "POST /people/{id}/password": (call) =>
    withPassword(call, Object.assign(call.row, { revision: call.row.revision + 1 }), "amber kettle north"),
  "POST /people/{id}/erase": erase,
  "DELETE /people/{id}/sessions": ({ world, row }) => {
    const before = world.sessions.length;
    world.sessions = world.sessions.filter(({ person }) => person !== row);
    return { ended: before - world.sessions.length };
  },
  "POST /roster": importRoster,
  "POST /cohorts": ({ world, rows, body }) =>
    rows.some(({ name }) => name === body.name)
      ? conflict("expected a name that no cohort has", "name")
      : added(world, rows, { ...body, archived_ms: 0, members: [] }),
  "PATCH /cohorts/{id}": ({ world, row, body: { name = row.name, archived = row.archived_ms > 0 } }) =>
    Object.assign(row, { name, archived_ms: archived ? world.nowMs : 0 }),
  "POST /cohorts/{id}/members": changeMembers,
};

// Stations, devices, the server

const kPhases = ["reading", "repairing", "filling", "storing"];

// A mesh in micrometres is refused: the tooth would be a thousand times too small.
function importedTooth({ world, row }) {
  if (row.state !== "working") return row;
  const phase = kPhases[row.looks++];
  if (row.asked.unit !== "mm" && row.looks > 1) {
    return Object.assign(row, {
      state: "refused",
      phase: "",
      problem: {
        code: "invalid_input",
        field: "unit",
        message: "crown: expected a tooth of 3 to 40 mm, found 0.01 mm with unit um; in mm it is 11.2 mm: choose mm",
      },
    });
  }
  if (phase !== undefined) return Object.assign(row, { phase, share: 0.5 });
  const exercises = ["class-1", "crown"].map((name) => ({
    id: newId(world),
    name: `${name}-crown-46`,
    title: name,
    version: 1,
  }));
  return Object.assign(row, {
    state: "done",
    phase: "",
    findings: ["5124 triangles, closed", "size 11.21 x 10.02 x 7.35 mm", "tissues assumed by depth from the surface"],
    tooth: { name: "crown-46", title: row.asked.title, exercises },
  });
}

function takeBytes({ row, query, bytes }) {
  if (query.offset !== row.received) return conflict(`expected the bytes from ${row.received} on`, "offset");
  row.received += bytes.length;
  if (row.received === row.bytes) row.state = "working";
  return row;
}

function putProfile({ world, body, query }) {
  const problem = problemOf(kSchemas.device_profile, body);
  if (problem !== undefined) return invalid(problem.field, problem.message);
  const criteria = criteriaOf(body.coupling_mn_per_mm.value);
  const acceptable = criteria.every(({ met }) => met);
  const stored = acceptable && !query.dry_run;
  const judgement = { name: body.name, stored, version: acceptable ? 3 : null, acceptable, criteria };
  if (!acceptable) return invalid("coupling_mn_per_mm", "expected Kc <= 2 b / (T (d + 1)^2)", judgement);
  if (stored)
    Object.assign(
      world.profiles.find(({ name }) => name === body.name),
      { version: 3, criteria },
    );
  return new Reply(judgement, { status: stored ? 201 : 200 });
}

// The slower device feels less of what is hard.
function feelOf({ row }) {
  const verdicts =
    row.coupling > 10_000 ? ["felt", "felt", "felt", "felt"] : ["beyond_force", "late", "device_cannot", "felt"];
  const figures = { error: 0.05, gain: row.coupling > 10_000 ? 1 : 0.6, lag_s: 0.02, rise_s: 0.02 };
  return {
    ...row,
    has_motors: true,
    coupling_mn_per_mm: row.coupling,
    tissues_of_scenes: true,
    thresholds: [
      { name: "force", value: 0.07, unit: "share", source: "Jones 1989" },
      { name: "viscosity", value: 0.19, unit: "share", source: "Jones 1997" },
      {
        name: "delay",
        value: 0.015,
        unit: "s",
        source: "Rank, Shi, Mueller and Hirche 2010, EuroHaptics, LNCS 6191, chapter 30",
      },
    ],
    tissues: [
      [["enamel", "neighbour"], 8700],
      [["dentin"], 5200],
      [["caries"], 1000],
      [["pulp"], 300],
    ].map(([names, damping]) => ({ names, damping_mn_s_per_mm: damping, scenes: ["Lower first molar"] })),
    cells: verdicts.flatMap((verdict, tissue) =>
      [0.1, 0.43, 1].flatMap((speed) =>
        ["steady", "strokes"].map((motion) => ({
          tissue,
          speed_mm_per_s: speed,
          motion,
          force_rms_n: 2.1,
          force_largest_n: 3.3,
          law: figures,
          oracle: figures,
          verdict,
        })),
      ),
    ),
  };
}

// Everything is well but for `world.trouble`, which a flow makes.
const health = ({ world }) => ({
  now_ms: Date.now(),
  started_ms: Date.now() - 108_000_000,
  ingest: { takes_recordings: true },
  disk: { free_bytes: 214e9, kept_free_bytes: 268_435_456 },
  jobs: { counted_up_to: 200 },
  stations: { enrolled: 7 },
  backup: { at_ms: Date.now() - 32_400_000 },
  retention: [{ what: "recordings", days: 730 }],
  ...world.trouble,
});

const operationRules = {
  "POST /listed-devices": ({ world, body }) => {
    world.devices = [...world.devices.filter(({ name }) => name !== body.name), { ...body, added_ms: world.nowMs }];
    return world;
  },
  "POST /listed-devices/remove": ({ world, body }) => {
    world.devices = world.devices.filter(({ name }) => name !== body.name);
    return world;
  },
  "POST /stations/{id}/revoke": ({ world, row }) =>
    Object.assign(row, { revoked: true, revoked_ms: world.nowMs, revision: row.revision + 1 }),
  "POST /enrolment-codes": ({ world, rows, body }) => ({
    ...added(world, rows, { expires_ms: world.nowMs + body.minutes * 60_000 }),
    code: `5f2c9a71b3d84e06@${"9c".repeat(32)}`,
    station_port: 8600,
  }),
  "POST /profiles": putProfile,
  "GET /profiles/{name}/feel": feelOf,
  "POST /profiles/{name}/reports": ({ world, row, request, bytes }) => {
    row.reports.unshift({
      id: newId(world),
      version: 2,
      media_type: request.headers["content-type"],
      bytes: bytes.length,
      created_ms: world.nowMs,
    });
    return row.reports[0];
  },
  "GET /profile-reports/{id}": () => ({ format: 1, rows: [], strokes: golden("strokes"), ...golden("lab_report") }),
  "POST /profiles/{name}/calibrations": ({ world, row, body }) => {
    if (body.profile !== row.name)
      return invalid("profile", `expected a calibration of "${row.name}", found one of "${body.profile}"`);
    row.calibrations.unshift({ ...body, id: newId(world), added_ms: world.nowMs, document: body });
    return row.calibrations[0];
  },
  "POST /builtin-teeth": ({ world, body }) => {
    world.exercises.push(...world.shelf.splice(0));
    return { name: `${body.name}-46`, title: "Lower first molar", exercises: world.exercises };
  },
  "POST /tooth-imports": ({ world, rows, body }) =>
    added(world, rows, { state: "receiving", received: 0, bytes: body.bytes, looks: 0, asked: body }),
  "GET /tooth-imports/{id}": importedTooth,
  "PUT /tooth-imports/{id}/bytes": takeBytes,
  "GET /health": health,
  "POST /jobs/{id}/cancel": ({ row }) => {
    if (!["queued", "running"].includes(row.state)) return conflict("The job is over already.");
    row.state = "cancelled";
    return undefined;
  },
};

// Exercises and their rubrics

const kSchemas = {
  device_profile: documentSchema("device_profile"),
  exercise: documentSchema("exercise"),
  rubric: documentSchema("rubric"),
};
const kDocument = golden("scene_exercise_gates");

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
function documentOf({ documents }, { id, name, title, instructions, graded, version, revision }) {
  if (!documents.has(id))
    documents.set(id, {
      ...kDocument,
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
      { version: 1, published_ms: row.published_ms, document: { format: 1, ...documentOf(world, row).rubric } },
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
    return conflict("the rubric that counts says the same already");
  rubrics.unshift({ version: rubrics[0].version + 1, reason, published_ms: world.nowMs, document });
  return new Reply(rubrics[0], { tag: rubrics[0].version });
}

const exerciseRules = {
  "GET /exercises": (call) => ({
    exercises: call.rows
      .filter(({ state }) => state === (call.query.state ?? "published"))
      .map((row) => views.exercises(row, call)),
  }),
  "POST /exercises": keepDraft,
  "PUT /exercises/{id}": keepDraft,
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
  if (terms.due_ms > 0 && terms.due_ms <= terms.opens_ms)
    return invalid("due_ms", "expected due_ms after opens_ms, or 0 for never");
  return {
    hands: "listed",
    counting: "best",
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
    assignment: views.assignments(row, call),
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
      ...views.assignments(each, call),
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

const assignmentRules = {
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

export const rules = { ...peopleRules, ...operationRules, ...exerciseRules, ...assignmentRules, ...attemptRules };
