// What the contract does not say about the mock server's routes: permissions, effects, computed
// values. A rule gets a call (session, row, query and body) and returns the value of the answer.
import { randomBytes } from "node:crypto";
import { conflict, documentSchema, forbidden, golden, invalid, problemOf, refused, Reply } from "./contract.mjs";
import { attemptRules, attemptView } from "./mock_attempts.mjs";
import { criteriaOf, kReference } from "./mock_exercises.mjs";
import { markingRules } from "./mock_marking.mjs";
import { assignmentRules, assignmentView, exerciseRules, exerciseView } from "./mock_teaching.mjs";
import { added, newId } from "./mock_world.mjs";

const teaches = ({ role }) => role !== "student";
const kAdmins =
  /^(\w+ \/(people|roster|audit|health|backups|jobs|builtin-teeth|tooth-imports|enrolment-codes)|(POST|PATCH|DELETE) \/(cohorts|stations|listed-devices|profiles))/;
const kStaff =
  /^(\w+ \/(cohorts|stations|listed-devices|live|profile-reports|scoring-metrics|references|annotations|markings|marking-works)|(POST|PUT|DELETE) \/(exercises|assignments|attempts)|GET \/profiles\/.*(versions|reports|calibrations)|GET .*\/(live|insight|rubrics|markings)|PUT \/session\/pin)/;

export function mayCall({ route }, { role }) {
  if (route === "POST /attempts/{id}/appeal") return true;
  return kAdmins.test(route) ? role === "admin" : kStaff.test(route) ? role !== "student" : true;
}

// Whether the password has to have been given lately.
export function confirmed({ operation: { route }, query }) {
  if (route === "POST /roster") return !query.dry_run;
  return [
    "PUT /session/pin",
    "POST /people",
    "POST /people/{id}/password",
    "POST /people/{id}/erase",
    "POST /stations/{id}/revoke",
    "POST /enrolment-codes",
  ].includes(route);
}

export const visible = {
  attempts: (row, { person, operation }) =>
    teaches(person) ||
    row.person === person ||
    // How the reference was cut; every attempt of the mock was compared with it.
    (row.id === kReference.attempt_id && /\/(series|timeline)$/.test(operation.path)),
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
  exercises: exerciseView,
  assignments: assignmentView,
  attempts: attemptView,
};

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
  return person === undefined
    ? refused(401, "unauthenticated", "Login and password do not match.")
    : newSession(world, person);
}

// With a csrf value of its own, as each session of the real server has.
function newSession(world, person) {
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

function changePassword({ world, person, body }) {
  if (body.old_password !== person.password) return forbidden("That is not your password.", "old_password");
  Object.assign(person, { password: body.new_password, must_change_password: false });
  world.sessions = world.sessions.filter((other) => other.person !== person);
  return newSession(world, person);
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
  if (body.token !== world.firstAdminToken) return forbidden("This link has expired or was used.", "token");
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
  if (body.login !== row.login)
    return invalid("login", "that is not the person's login; type it to confirm, because this cannot be undone");
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
  "PUT /session/pin": ({ person, body }) => {
    if (/^(\d)\1*$/.test(body.pin)) return invalid("pin", "this PIN is easy to guess");
    person.pin = body.pin;
    return undefined;
  },
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

const kProfileSchema = documentSchema("device_profile");

function putProfile({ world, body, query }) {
  const problem = problemOf(kProfileSchema, body);
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

const kFilesToBackUp = 400;

// One that was started is done at the third look.
function backupsNow(world, looked) {
  const { backup } = world;
  if (backup !== undefined && looked && ++backup.looks > 2) {
    world.backedUpMs = Date.now();
    delete world.backup;
  }
  const running = world.backup && {
    since_ms: backup.since_ms,
    here: true,
    phase: "blobs",
    done: 120 * backup.looks,
    all: kFilesToBackUp,
  };
  return { folder: "/var/backups/enamel", running: running ?? null, failed: null };
}

// Everything is well but for `world.trouble`, which a flow makes.
const health = ({ world }) => ({
  backups: backupsNow(world, true),
  now_ms: Date.now(),
  started_ms: Date.now() - 108_000_000,
  ingest: { takes_recordings: true },
  disk: { free_bytes: 214e9, kept_free_bytes: 268_435_456 },
  jobs: { counted_up_to: 200 },
  stations: { enrolled: 7 },
  backup: {
    at_ms: world.backedUpMs ?? Date.now() - 32_400_000,
    bytes: 2_140_000_000,
    place: "/var/backups/enamel/2026-09-01T030000",
  },
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
  "POST /backups": ({ world }) => {
    if (world.backup !== undefined) return conflict("a backup is running; wait until it is done");
    world.backup = { since_ms: Date.now(), looks: 0 };
    return backupsNow(world, false);
  },
  "POST /jobs/{id}/cancel": ({ row }) => {
    if (!["queued", "running"].includes(row.state)) return conflict("The job is over already.");
    row.state = "cancelled";
    return undefined;
  },
};

export const rules = {
  ...peopleRules,
  ...operationRules,
  ...exerciseRules,
  ...assignmentRules,
  ...attemptRules,
  ...markingRules,
};
