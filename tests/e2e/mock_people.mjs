// People, sessions, cohorts, stations, profiles, jobs and audit of the mock server.
import { readFileSync } from "node:fs";
import { feelOf } from "./mock_feel.mjs";
import { conflict, edit, empty, invalid, json, notFound, page, refusal, tagged } from "./mock_reply.mjs";
import { criteriaOf, newId } from "./mock_world.mjs";

const kConfirmedMs = 5 * 60_000;
const kOneTimeMs = 7 * 86_400_000;
const kNotConfirmed = () => refusal(403, "confirm_password", "Give your password again: POST /api/v1/session/confirm.");

const personView = ({ id, login, display_name, role, disabled, must_change_password, created_ms, revision }) =>
  ({ id, login, display_name, role, disabled, must_change_password, created_ms, revision });
const byId = (rows, id) => rows.find((row) => row.id === id);

function cohortView(world, cohort) {
  const members = cohort.members.map((id) => byId(world.people, id)).map(({ id, login, display_name, role }) => ({ id, login, display_name, role }));
  return { id: cohort.id, name: cohort.name, archived_ms: cohort.archived_ms, revision: cohort.revision, members };
}

function sessionsOf(world, person, current) {
  return [...world.sessions.values()].filter((session) => session.person.id === person.id).map((session) => ({
    id: session.id, via: session.via, address: session.address, device: session.device, created_ms: session.created_ms, last_used_ms: session.created_ms, expires_ms: session.created_ms + 43_200_000, current: session === current }));
}

const fresh = ({ session, world }) => world.nowMs - session.confirmedMs < kConfirmedMs;

function listPeople({ world, query }) {
  const text = (query.get("text") ?? "").toLowerCase();
  const members = query.get("cohort") === null ? undefined : byId(world.cohorts, query.get("cohort"))?.members ?? [];
  const rows = world.people.filter((person) => (text === "" || person.login.includes(text) || person.display_name.toLowerCase().includes(text)) &&
    (query.get("role") === null || person.role === query.get("role")) && (members === undefined || members.includes(person.id)));
  return page("people", [...rows].sort((a, b) => a.login.localeCompare(b.login)).map(personView), query);
}

function addPerson(call) {
  const { world, body } = call;
  if (!fresh(call)) return kNotConfirmed();
  if (!/^[a-z0-9._-]+$/.test(body.login ?? "")) return invalid("login", "expected letters a-z, digits, dot, minus or underscore");
  if (world.people.some((person) => person.login === body.login)) return refusal(409, "conflict", "expected a login that nobody has", "login");
  const person = { id: newId(world), password: "quiet river lamp", disabled: false, must_change_password: true, created_ms: world.nowMs, revision: 1, ...body };
  world.people.push(person);
  return json({ ...personView(person), password: person.password, password_until_ms: world.nowMs + kOneTimeMs }, 201);
}

function editPerson({ world, request, id, body }) {
  const person = byId(world.people, id);
  if (person === undefined) return notFound();
  return edit(request, person, personView, (row) => {
    if (body.display_name === "") return invalid("display_name", "expected a name");
    Object.assign(row, body);
    return undefined;
  });
}

function resetPassword(call) {
  if (!fresh(call)) return kNotConfirmed();
  const person = byId(call.world.people, call.id);
  Object.assign(person, { password: "amber kettle north", must_change_password: true, revision: person.revision + 1 });
  return json({ ...personView(person), password: person.password, password_until_ms: call.world.nowMs + kOneTimeMs });
}

function importRoster({ world, query, text }) {
  const trial = query.get("dry_run") === "true";
  const [header, ...lines] = text.replace(/^\uFEFF/, "").split(/\r?\n/).filter((line) => line !== "");
  const columns = (header ?? "").split(",");
  const problems = [];
  if (!columns.includes("login")) problems.push({ row: 1, column: "login", found: header ?? "", expected: "a column named login" });
  const rows = lines.map((line, i) => ({ row: i + 2, ...Object.fromEntries(line.split(",").map((cell, column) => [columns[column], cell])) }));
  for (const row of rows) {
    if (!["student", "instructor", "admin"].includes(row.role)) problems.push({ row: row.row, column: "role", found: row.role ?? "", expected: "student, instructor or admin" });
    if (/^[=+@-]/.test(row.display_name ?? "")) problems.push({ row: row.row, column: "display_name", found: row.display_name, expected: "a name that no spreadsheet takes for a formula" });
  }
  const people = rows.map((row) => ({ row: row.row, login: row.login, change: world.people.some((person) => person.login === row.login) ? "unchanged" : "create",
                                      renames: false, joins: row.cohort !== "", note: "" }));
  const made = rows.filter((_, i) => people[i].change === "create");
  const report = {
    done: !trial && problems.length === 0, created: made.length, updated: 0, unchanged: rows.length - made.length, new_cohorts: [], ignored_columns: [],
    problem_count: problems.length, problems, people, passwords: [] };
  if (problems.length > 0) return json({ ...report, error: { code: "invalid_input", message: "expected a roster without problems", field: "body" } }, 400);
  if (trial) return json(report);
  report.passwords = made.map(({ login, display_name, cohort }, i) => ({ login, display_name, cohort, password: `copper lantern ${i + 1}` }));
  world.people.push(...made.map(({ login, display_name, role }) => ({
    id: newId(world), login, display_name, role, password: "copper lantern", disabled: false, must_change_password: true, created_ms: world.nowMs, revision: 1 })));
  return json(report);
}

function changePassword({ world, session, body }) {
  const { person } = session;
  if (body.old_password !== person.password) return refusal(403, "forbidden", "expected the password until now", "old_password");
  if ((body.new_password ?? "").length < 8) return invalid("new_password", "a password has 8 to 1024 characters");
  Object.assign(person, { password: body.new_password, must_change_password: false });
  for (const [token, other] of world.sessions) if (other.person === person && other !== session) world.sessions.delete(token);
  return json(sessionView(session));
}

export function sessionView({ person: { id, login, display_name, role, must_change_password, language = "" }, csrf, confirmedMs }) {
  return { person: { id, login, display_name, role }, csrf, must_change_password, language, confirmed_until_ms: confirmedMs + kConfirmedMs };
}

function confirm({ world, session, body }) {
  if (body.password !== session.person.password) return refusal(403, "forbidden", "This is not the password.", "password");
  session.confirmedMs = world.nowMs;
  return empty();
}

function endSession({ world, id, person }) {
  for (const [token, session] of world.sessions) {
    if (session.id !== id || (session.person !== person && person.role !== "admin")) continue;
    world.sessions.delete(token);
    return empty();
  }
  return notFound();
}

function changeMembers({ world, id, body }) {
  const cohort = byId(world.cohorts, id);
  const removed = new Set(body.remove ?? []);
  cohort.members = [...new Set([...cohort.members, ...(body.add ?? [])])].filter((member) => !removed.has(member));
  cohort.revision += 1;
  return tagged(cohortView(world, cohort));
}

function editCohort({ world, request, id, body: { name, archived } }) {
  return edit(request, byId(world.cohorts, id), (row) => cohortView(world, row), (row) => {
    if (name !== undefined) row.name = name;
    if (archived !== undefined) row.archived_ms = archived ? world.nowMs : 0;
    return undefined;
  });
}

const visibleCohorts = ({ world, person, query }) => world.cohorts.filter((cohort) =>
  (person.role === "admin" || cohort.members.includes(person.id)) && (cohort.archived_ms > 0) === (query.get("archived") === "true"));

function renameStation({ world, request, id, body }) {
  return edit(request, byId(world.stations, id), (row) => row, (row) => {
    if (world.stations.some((other) => other.name === body.name && other.id !== id)) return refusal(409, "conflict", "expected a name that no station has", "name");
    row.name = body.name;
    return undefined;
  });
}

function revokeStation(call) {
  if (!fresh(call)) return kNotConfirmed();
  const station = byId(call.world.stations, call.id);
  Object.assign(station, { revoked: true, revoked_ms: call.world.nowMs, revision: station.revision + 1 });
  return tagged(station);
}

function makeCode({ world, body }) {
  const code = { id: newId(world), created_ms: world.nowMs, expires_ms: world.nowMs + body.minutes * 60_000 };
  world.codes.push(code);
  return json({ id: code.id, code: `5f2c9a71b3d84e06@${"9c".repeat(32)}`, station_port: 8600, expires_ms: code.expires_ms }, 201);
}

function withdrawCode({ world, id }) {
  world.codes = world.codes.filter((code) => code.id !== id);
  return empty();
}

// What enamel-lab qualify writes of strokes and of other suites.
const golden = (name) => JSON.parse(readFileSync(new URL(`../../schemas/golden/${name}.json`, import.meta.url), "utf8"));
const kStrokesReport = { format: 1, rows: [], strokes: golden("strokes"), ...golden("lab_report") };
const profileView = ({ versions: _versions, reports: _reports, criteria: _criteria, document: _document, ...profile }) => profile;

function putProfile({ world, body, query }) {
  if (!Number.isInteger(body.coupling_mn_per_mm?.value ?? 1)) return invalid("coupling_mn_per_mm.value", "expected a whole number");
  const coupling = body.coupling_mn_per_mm?.value;
  if (coupling === undefined) return invalid("coupling_mn_per_mm.value", "expected a whole number of mN/mm, found nothing");
  const criteria = criteriaOf(coupling);
  const acceptable = criteria.every((item) => item.met);
  const judgement = { name: body.name, stored: acceptable && query.get("dry_run") !== "true", version: acceptable ? 3 : null, acceptable, criteria };
  if (!acceptable) return json({ ...judgement, error: { code: "invalid_input", message: "expected Kc <= 2 b / (T (d + 1)^2)", field: "coupling_mn_per_mm" } }, 400);
  if (query.get("dry_run") === "true") return json(judgement);
  const profile = world.profiles.find((item) => item.name === body.name);
  if (profile !== undefined) Object.assign(profile, { version: 3, criteria });
  return json(judgement, 201);
}

function addCalibration({ world, id, body }) {
  if (body.profile !== id) return invalid("profile", `expected a calibration of "${id}", found one of "${body.profile}"`);
  const calibration = { id: newId(world), profile: id, device: body.device, measured_ms: body.measured_ms, added_ms: world.nowMs, document: body };
  world.calibrations.unshift(calibration);
  return json(calibration, 201);
}

function listAudit({ world, query }) {
  const within = (entry) => (query.get("actor") === null || entry.actor_id === query.get("actor")) && (query.get("action") === null || entry.action === query.get("action") || (query.get("action").endsWith(".") && entry.action.startsWith(query.get("action")))) &&
    (query.get("object") === null || entry.object === query.get("object")) &&
    entry.at_ms >= Number(query.get("from_ms") ?? 0) && entry.at_ms <= Number(query.get("until_ms") ?? Infinity);
  return page("audit", world.audit.filter(within).map(({ actor_id: _actor, ...entry }) => entry), query, 100);
}

function cancelJob({ world, id }) {
  const job = byId(world.jobs, id);
  if (job === undefined || !["queued", "running"].includes(job.state)) return conflict("The job is over already.");
  job.state = "cancelled";
  return empty();
}

const profileOf = ({ world, id }) => world.profiles.find((profile) => profile.name === id);
const orMissing = (found, answer) => found === undefined ? notFound() : answer(found);

// "METHOD /path with {id}": [who may, answer].
// Schema ServerHealth. `world.trouble` is what the flows make go wrong.
function serverHealth({ world }) {
  const hour = 3_600_000;
  const health = {
    now_ms: Date.now(), started_ms: Date.now() - 30 * hour,
    ingest: { takes_recordings: true, problem: "", waiting: "", chunks: 48_210, chunk_bytes: 81_400_000, sealed: 312 },
    commits: { count: 50_120, failed: 0, timed: 1000, p99_s: 0.0214 }, clock: { ahead_ms: 0, problem: "" }, standby: "",
    disk: { free_bytes: 214e9, kept_free_bytes: 268_435_456, database_bytes: 412e6, log_bytes: 4.1e6 },
    jobs: { queued: 1, running: 1, failed: 0, counted_up_to: 200 },
    stations: { enrolled: 7, online: 4 }, recordings: { open: 4, late: [] },
    sign_ins: { signed_in: 214, refused: 12, throttled: 0, busy: 0 },
    backup: { at_ms: Date.now() - 9 * hour, missing: 0 },
    retention: [{ what: "unfinished", days: 30 }, { what: "recordings", days: 730 }],
  };
  return json({ ...health, ...world.trouble });
}

const kPhases = ["reading", "repairing", "filling", "storing"];

// A tooth of a mesh: in micrometres it is refused, as one that is a thousand times too small.
function beginImport({ world, body }) {
  if (world.import?.state === "working") return refusal(503, "unavailable", "another tooth is being imported; try again when it is done");
  if (!/\.(stl|ply|obj|off)$/i.test(body.file_name)) return invalid("file_name", "expected a file named .stl, .ply, .obj or .off, found another; export the mesh as one of these");
  world.import = { id: newId(world), state: "receiving", received: 0, bytes: body.bytes, phase: "", share: 0, findings: [], problem: null, tooth: null, asked: body, looks: 0 };
  return json(world.import, 201);
}

function workOn(world) {
  const now = world.import;
  if (now?.state !== "working") return now ?? {};
  const phase = kPhases[now.looks++];
  if (now.asked.unit !== "mm" && now.looks > 1) {
    return Object.assign(now, { state: "refused", phase: "", problem: { code: "invalid_input", field: "unit", message: "crown: expected a tooth of 3 to 40 mm, found 0.01 mm with unit um; in mm it is 11.2 mm: choose mm" } });
  }
  if (phase !== undefined) return Object.assign(now, { phase, share: 0.5 });
  const tooth = { name: "crown-46", title: now.asked.title, exercises: [{ id: newId(world), name: "class-1-crown-46", title: "Class I", version: 1 }, { id: newId(world), name: "crown-crown-46", title: "Crown", version: 1 }] };
  return Object.assign(now, { state: "done", phase: "", findings: ["5124 triangles, closed", "size 11.21 x 10.02 x 7.35 mm", "tissues assumed by depth from the surface"], tooth });
}

export const peopleRoutes = {
  "GET /people": ["admin", listPeople],
  "POST /people": ["admin", addPerson],
  "GET /people/{id}": ["admin", (call) => orMissing(byId(call.world.people, call.id), (person) => tagged({ ...personView(person),
    cohorts: call.world.cohorts.filter((cohort) => cohort.members.includes(person.id)).map(({ id, name }) => ({ id, name })) }))],
  "PATCH /people/{id}": ["admin", editPerson],
  "POST /people/{id}/password": ["admin", resetPassword],
  "GET /people/{id}/sessions": ["admin", (call) => page("sessions", sessionsOf(call.world, byId(call.world.people, call.id), call.session), call.query)],
  "DELETE /people/{id}/sessions": ["admin", ({ world, id }) => {
    const tokens = [...world.sessions].filter(([, session]) => session.person.id === id).map(([token]) => token);
    for (const token of tokens) world.sessions.delete(token);
    return json({ ended: tokens.length });
  }],
  "POST /people/{id}/erase": ["admin", (call) => {
    const person = byId(call.world.people, call.id);
    if (!fresh(call)) return kNotConfirmed();
    if (call.body.login !== person.login) return invalid("login", "expected the person's login, because this cannot be undone");
    call.world.people = call.world.people.filter((other) => other !== person);
    for (const cohort of call.world.cohorts) cohort.members = cohort.members.filter((member) => member !== call.id);
    return json({ attempts: 2, references: 0, blobs: 4 });
  }],
  "POST /roster": ["admin", (call) => call.query.get("dry_run") === "true" || fresh(call) ? importRoster(call) : kNotConfirmed()],
  "GET /sessions": ["person", (call) => page("sessions", sessionsOf(call.world, call.person, call.session), call.query)],
  "DELETE /sessions/{id}": ["person", endSession],
  "POST /session/password": ["person", changePassword],
  "PUT /session/language": ["person", ({ session, body }) => { session.person.language = body.language; return json(sessionView(session)); }],
  "POST /session/confirm": ["person", confirm],
  "GET /cohorts": ["instructor", (call) => page("cohorts", visibleCohorts(call).map((cohort) => cohortView(call.world, cohort)), call.query)],
  "POST /cohorts": ["admin", ({ world, body }) => {
    if (world.cohorts.some((cohort) => cohort.name === body.name)) return refusal(409, "conflict", "expected a name that no cohort has", "name");
    const cohort = { id: newId(world), name: body.name, archived_ms: 0, revision: 1, members: [] };
    world.cohorts.push(cohort);
    return json(cohortView(world, cohort), 201);
  }],
  "GET /cohorts/{id}": ["instructor", (call) => orMissing(byId(call.world.cohorts, call.id), (cohort) => tagged(cohortView(call.world, cohort)))],
  "PATCH /cohorts/{id}": ["admin", editCohort],
  "POST /cohorts/{id}/members": ["admin", changeMembers],
  "GET /listed-devices": ["instructor", ({ world }) => json({ devices: world.devices })],
  "POST /listed-devices": ["admin", ({ world, body: { name, title } }) => {
    world.devices = [...world.devices.filter((row) => row.name !== name), { name, title, added_ms: world.nowMs }];
    return json({ devices: world.devices });
  }],
  "POST /listed-devices/remove": ["admin", ({ world, body: { name } }) => {
    world.devices = world.devices.filter((row) => row.name !== name);
    return json({ devices: world.devices });
  }],
  "GET /stations": ["instructor", ({ world, query }) => page("stations", world.stations, query, 200)],
  "PATCH /stations/{id}": ["admin", renameStation],
  "POST /stations/{id}/revoke": ["admin", revokeStation],
  "GET /enrolment-codes": ["admin", ({ world, query }) => page("codes", world.codes, query)],
  "POST /enrolment-codes": ["admin", (call) => fresh(call) ? makeCode(call) : kNotConfirmed()],
  "DELETE /enrolment-codes/{id}": ["admin", withdrawCode],
  "GET /profiles": ["person", ({ world, query }) => page("profiles", world.profiles.map(profileView), query)],
  "POST /profiles": ["admin", putProfile],
  "GET /profiles/{name}": ["person", (call) => orMissing(profileOf(call), ({ versions: _versions, reports: _reports, ...profile }) => json({ ...profile, acceptable: true }))],
  "GET /profiles/{name}/feel": ["person", (call) => orMissing(profileOf(call), (profile) => json(feelOf(profile)))],
  "GET /profiles/{name}/versions": ["instructor", (call) => page("versions", profileOf(call).versions, call.query)],
  "GET /profiles/{name}/reports": ["instructor", (call) => page("reports", profileOf(call).reports, call.query)],
  "POST /profiles/{name}/reports": ["admin", (call) => {
    const report = { id: newId(call.world), version: 2, media_type: call.request.headers["content-type"], bytes: call.text.length, created_ms: call.world.nowMs };
    profileOf(call).reports.unshift(report);
    return json(report, 201);
  }],
  "GET /profile-reports/{id}": ["instructor", () => json(kStrokesReport)],
  "GET /profiles/{name}/calibrations": ["instructor", (call) => page("calibrations", call.world.calibrations.filter((item) => item.profile === call.id), call.query)],
  "POST /profiles/{name}/calibrations": ["admin", addCalibration],
  "GET /audit": ["admin", listAudit],
  "GET /builtin-teeth": ["admin", () => json({ teeth: [{ name: "block", summary: "a block with shapes to cut" }, { name: "molar", summary: "a lower first molar" }] })],
  "POST /builtin-teeth": ["admin", ({ world, body }) => {
    world.exercises.push(...world.shelf.splice(0));
    return json({ name: `${body.name}-46`, title: "Lower first molar", exercises: world.exercises.map(({ id, name, title, version }) => ({ id, name, title, version })) }, 201);
  }],
  "POST /tooth-imports": ["admin", beginImport],
  "GET /tooth-imports/{id}": ["admin", ({ world }) => json(workOn(world))],
  "PUT /tooth-imports/{id}/bytes": ["admin", ({ world, query, text }) => {
    const now = world.import;
    if (Number(query.get("offset")) !== now.received) return refusal(409, "conflict", `expected the bytes from ${now.received} on`, "offset");
    now.received += Math.min(text.length, now.bytes - now.received);
    if (now.received === now.bytes) now.state = "working";
    return json(now);
  }],
  "DELETE /tooth-imports/{id}": ["admin", ({ world }) => { delete world.import; return empty(); }],
  "GET /health": ["admin", serverHealth],
  "GET /jobs": ["admin", ({ world, query }) => page("jobs", world.jobs.filter((job) => query.get("state") === null || job.state === query.get("state")), query)],
  "POST /jobs/{id}/cancel": ["admin", cancelJob],
};
