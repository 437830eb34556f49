// What the mock server remembers: invented people, things and attempts in the shapes of
// schemas/api/openapi.yaml. A fresh world for every server, because the flows change it.
import { appealOf, attemptRow, exerciseRows, id, kDayMs, kMinuteMs, kStartMs, people as knownPeople } from "./mock_data.mjs";

export function makeWorld(dist) {
  const world = {
    dist, sessions: new Map(), surfaces: new Map(), nextId: 9000, nowMs: Date.now(), confirmedUntil: 0,
    people: makePeople(), exercises: exerciseRows(), audit: [], codes: [], live: new Set(),
  };
  const [student, second, instructor, admin] = world.people;
  world.cohorts = [
    cohort(10, "Preclinic, first term", [student, second, instructor, ...world.people.slice(5, 25)]),
    cohort(11, "Preclinic, second term", [instructor]),
  ];
  world.devices = [{ name: "hid:1209:0001:A7", title: "Chair 3", added_ms: world.nowMs - 20 * kDayMs }];
  world.stations = [
    station(30, "Station 1", world.nowMs - 20_000, "enamel-station 1.0.0"), station(31, "Station 2", 0, "", true),
    ...Array.from({ length: 6 }, (_, i) => station(32 + i, `Station ${3 + i}`, world.nowMs - (i + 1) * 3 * 3_600_000, "enamel-station 1.0.0")),
  ];
  world.assignments = makeAssignments(world);
  world.attempts = makeAttempts(world, { student, second, instructor });
  world.annotations = makeAnnotations(instructor);
  world.references = [
    { id: id(301), exercise_id: id(20), attempt_id: id(101), dentist: "Dentist One", consent: true, version: 1, created_ms: kStartMs, withdrawn_ms: 0 }];
  world.jobs = makeJobs();
  world.profiles = makeProfiles();
  world.calibrations = makeCalibrations();
  world.audit = makeAudit(admin, instructor);
  world.codes = [{ id: id(401), created_ms: world.nowMs - 10 * kMinuteMs, expires_ms: world.nowMs + 50 * kMinuteMs }];
  return world;
}

export function newId(world) {
  return id(world.nextId++);
}

function makePeople() {
  const others = Array.from({ length: 140 }, (_, i) => ({
    id: id(1000 + i), login: `student${i + 3}`, password: "a long student phrase", display_name: `Student ${i + 3}`, role: "student" }));
  return [...knownPeople, ...others].map((person, i) => ({
    disabled: i === 30, must_change_password: person.login === "newcomer" || i > 100, created_ms: kStartMs - 90 * kDayMs, revision: 1, ...person }));
}

function cohort(number, name, members) {
  return { id: id(number), name, archived_ms: 0, revision: 1, members: members.map((person) => person.id) };
}

function station(number, name, lastSeenMs, software, revoked = false) {
  return { id: id(number), name, revoked, revoked_ms: revoked ? kStartMs : 0, enrolled_ms: kStartMs - 90 * kDayMs, last_seen_ms: lastSeenMs, software,
           core_version: software === "" ? 0 : 3, revision: 1 };
}

function makeAssignments(world) {
  const now = world.nowMs;
  const row = (number, exercise, changes) => ({
    id: id(number), exercise, cohort: id(10), opens_ms: 0, due_ms: 0, attempt_limit: 0, exam: false, late_allowed: false, hands: "listed", counting: "best", stations: [],
    created_ms: kStartMs, revision: 1, ...changes });
  return [
    row(500, "class-1-occlusal", { opens_ms: now - 10 * kDayMs, due_ms: now + 4 * kDayMs, attempt_limit: 3 }),
    row(501, "class-1-practice", {}),
    row(502, "class-2-mesial", { opens_ms: now + 6 * kDayMs, due_ms: now + 6 * kDayMs + 90 * kMinuteMs, attempt_limit: 1, exam: true, stations: [id(30), id(32)] }),
  ];
}

function makeAttempts(world, { student, second, instructor }) {
  const unscored = { score: null, computed_score: null, critical_fail: null, progress: 0 };
  const graded = { assignment_id: id(500), due_ms: world.nowMs + 4 * kDayMs };
  const older = Array.from({ length: 55 }, (_, i) => attemptRow(200 + i, second, 1, {
    ticketed_ms: kStartMs - (i + 1) * kDayMs, released: true, score: Math.round((90 - i * 0.8) * 10) / 10, assignment_id: id(501) }));
  const crowd = world.people.slice(5, 23).map((person, i) => attemptRow(600 + i, person, 0, {
    ...graded, score: 55 + ((i * 17) % 45), released: i % 3 === 0, ticketed_ms: kStartMs - i * kMinuteMs, flags: i === 4 ? ["late"] : i === 6 ? ["faster_than_time", "near_another"] : [], stopped: i === 5 }));
  const recording = (number, person, place) => attemptRow(number, person, 1, {
    state: "recording", ...unscored, station: { id: id(place), name: `Station ${place - 29}` }, sealed_ms: 0, ticks: 12_000 });
  return [
    recording(110, student, 30), { ...recording(111, second, 32), exercise: { id: id(20), title: "Occlusal cavity, class I" }, ticks: 430_000 }, recording(112, world.people[8], 33), recording(113, world.people[9], 34),
    attemptRow(107, second, 0, { state: "scoring", ...unscored, progress: 0.2, ...graded }),
    attemptRow(106, student, 0, graded),
    attemptRow(105, student, 1, { released: true, assignment_id: id(501) }),
    attemptRow(104, second, 0, { gap_ticks: 412, critical_fail: true, score: 0, ...graded }),
    attemptRow(103, second, 0, { state: "quarantined", ...unscored, problem: "Chunk 12 was received twice with different content. Both are kept." }),
    attemptRow(102, student, 0, { state: "failed", ...unscored, problem: "The volume of the scene is missing: restore its blob, then score again." }),
    attemptRow(101, instructor, 0, { as_reference: true, is_reference: true, score: 100 }),
    attemptRow(120, student, 0, { ...graded, released: true, score: 71.42857142857143, flags: ["over_time", "resumed"], ticketed_ms: kStartMs - kDayMs }),
    attemptRow(121, second, 0, { ...graded, released: true, score: 64.2, ticketed_ms: kStartMs - 2 * kDayMs,
      appeal: appealOf("The mesial wall was cut on purpose: the lesion reached there. Please look at second 20.") }),
    ...crowd, ...older,
  ];
}

function makeAnnotations(instructor) {
  const row = (number, attempt, tick, text, point, toChair = false) => ({
    id: id(number), attempt_id: id(attempt), author: { id: instructor.id, display_name: instructor.display_name }, tick, point_um: point, text, to_chair: toChair,
    created_ms: kStartMs + 60 * kMinuteMs, edited_ms: 0, revision: 1 });
  return [
    row(700, 105, 9_600, "Here the bur leans to mesial: keep the handpiece upright while you move along the wall.", [2300, 100, 900]),
    row(701, 105, 30_000, "Good light touch in the corner.", null, true),
    row(702, 120, 12_000, "Too deep at this point.", [-300, 0, -500]),
  ];
}

function makeJobs() {
  const job = (number, attempt, state, changes = {}) => ({
    id: id(number), kind: "score", cause: "seal", attempt_id: id(attempt), state, progress: state === "done" ? 1 : 0, tries: 1, error: "", ...changes });
  return [
    job(40, 102, "failed", { tries: 3, error: "The volume of the scene is missing." }), job(42, 107, "running", { progress: 0.35 }),
    job(43, 104, "queued", { cause: "rescore", tries: 0 }), job(41, 106, "done"),
  ];
}

const number = (name, value, unit, source) => ({ name, value, unit, source });
const criterion = (name, title, formula, unit, value, limit, changes = {}) => ({
  name, title, formula, unit, value, limit, at_least: false, met: changes.at_least === true ? value >= limit : value <= limit, ...changes });

export function criteriaOf(couplingMnPerMm) {
  return [
    criterion("coupling_damping", "Passive limit of the coupling", "Kc <= 2 b / (T (d + 1)^2)", "mN/mm", couplingMnPerMm, 1760),
    criterion("coupling_friction", "Friction that pays for the encoder's cell", "c >= Kc delta / 2", "mN", 60, (couplingMnPerMm * 0.023) / 2, { at_least: true }),
    criterion("coupling_stiffness", "Largest stiffness the device shows", "Kc <= K", "mN/mm", couplingMnPerMm, 1860),
    criterion("continuous_force", "Continuous force within the peak", "continuous <= peak", "mN", 1750, 7900),
  ];
}

function makeProfiles() {
  const profile = (name, title, numbers) => ({
    name, title, version: 2, created_ms: kStartMs, numbers, criteria: criteriaOf(1200), document: { format: 1, name, title, ...Object.fromEntries([["coupling_mn_per_mm", 1200], ["friction_mn", 60], ["peak_force_mn", 7900]].map(([member, value]) => [member, { value, source: "paper, table 1" }])) },
    versions: [{ version: 2, title, content: "ab".repeat(32), created_ms: kStartMs }, { version: 1, title, content: "cd".repeat(32), created_ms: kStartMs - 60 * kDayMs }],
    reports: [{ id: id(801), version: 2, media_type: "application/json", bytes: 48_210, created_ms: kStartMs }] });
  return [
    profile("phantom_desktop", "Phantom Desktop", [
      number("resolution", 23_000, "nm", "paper, table 1"), number("max_stiffness", 1860, "mN/mm", "paper, table 1"), number("coupling", 1200, "mN/mm", "measured"),
      number("damping", 880, "mN s/m", "measured"), number("friction", 60, "mN", "paper, table 1"), number("peak_force", 7900, "mN", "datasheet"),
      number("mass", 45, "g", "assumption")]),
    profile("omega_6", "Omega 6", [number("resolution", 10_000, "nm", "paper, table 1"), number("peak_force", 12_000, "mN", "datasheet")]),
  ];
}

function makeCalibrations() {
  const measure = (value, uncertainty) => ({ value, uncertainty, samples: 2000 });
  return Array.from({ length: 7 }, (_, i) => {
    const measuredMs = kStartMs - (7 - i) * 30 * kDayMs;
    const worn = 1 + 0.03 * i;
    return {
      id: id(820 + i), profile: "phantom_desktop", device: "hid:0451:bef3 serial 1042", measured_ms: measuredMs, added_ms: measuredMs + kMinuteMs,
      document: {
        format: 1, device: "hid:0451:bef3 serial 1042", profile: "phantom_desktop", station: "Station 1", software: "enamel-station 1.0.0", measured_ms: measuredMs,
        rate_hz: 1000, method: "Guided: rest, slow sweep, free swing.",
        measured: { resolution_nm: measure(23_000 + 40 * i, 100), noise_nm: measure(900 + 30 * i, 60), friction_mn: measure(Math.round(58 * worn), 4),
                    damping_mn_s_per_m: measure(Math.round(860 * worn), 25) } },
    };
  }).reverse();
}

function makeAudit(admin, instructor) {
  const actions = [["attempt.release", instructor, '{"released":false}', '{"released":true}'], ["person.edit", admin, '{"role":"student"}', '{"role":"instructor"}'],
                   ["attempt.seal", undefined, "", '{"ticks":42180}'], ["assignment.add", instructor, "", '{"exercise":"class-1-occlusal","attempt_limit":3}']];
  return Array.from({ length: 130 }, (_, i) => {
    const [action, actor, before, after] = actions[i % actions.length];
    return { at_ms: kStartMs - i * 7 * kMinuteMs, actor: actor === undefined ? "station 1" : `${actor.id} (page)`, actor_id: actor?.id, action, object: id(100 + (i % 8)), before, after };
  });
}
