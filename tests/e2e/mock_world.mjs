// What the mock server remembers: as much of invented people, things and attempts as the flows look
// at. The contract's samples stand for the rest. Rows name each other by reference; an answer has
// as much of them as the contract says.
import { id, kDayMs, kMinuteMs, kStartMs, makeExercises, makeProfiles } from "./mock_exercises.mjs";

export const people = [
  { login: "student", password: "a long student phrase", display_name: "Student One", role: "student" },
  { login: "student2", password: "a long student phrase", display_name: "Student Two", role: "student" },
  { login: "instructor", password: "a long instructor phrase", display_name: "Instructor One", role: "instructor" },
  { login: "admin", password: "a long admin phrase", display_name: "Admin One", role: "admin" },
  {
    login: "newcomer",
    password: "given by the office",
    display_name: "Newcomer One",
    role: "student",
    must_change_password: true,
  },
];

export const newId = (world) => id(world.nextId++);

export function added(world, rows, row) {
  rows.push({ ...row, id: newId(world), created_ms: world.nowMs, revision: 1 });
  return rows.at(-1);
}

// A fresh one for every flow, because flows change it.
export function makeWorld() {
  const world = {
    nextId: 9000,
    nowMs: Date.now(),
    sessions: [],
    imports: [],
    trials: [],
    documents: new Map(),
    rubrics: new Map(),
  };
  world.people = makePeople();
  world.exercises = makeExercises();
  world.profiles = makeProfiles();
  const [student, second, instructor] = world.people;
  world.cohorts = [
    {
      id: id(10),
      name: "Preclinic, first term",
      archived_ms: 0,
      revision: 1,
      members: [student, second, instructor, ...world.people.slice(5, 25)],
    },
    { id: id(11), name: "Preclinic, second term", archived_ms: 0, revision: 1, members: [instructor] },
  ];
  world.devices = [{ name: "hid:1209:0001:A7", title: "Chair 3", added_ms: world.nowMs - 20 * kDayMs }];
  world.stations = Array.from({ length: 8 }, (_, i) => ({
    id: id(30 + i),
    name: `Station ${i + 1}`,
    revoked: i === 1,
    revoked_ms: i === 1 ? kStartMs : 0,
    last_seen_ms: i === 0 ? world.nowMs - 20_000 : world.nowMs - i * 3_600_000,
    enrolled_ms: kStartMs - 90 * kDayMs,
    software: "enamel-station 1.0.0",
    revision: 1,
  }));
  world.assignments = makeAssignments(world);
  world.attempts = makeAttempts(world);
  world.markings = [
    {
      id: id(901),
      assignment_id: id(502),
      created_ms: world.nowMs - kDayMs,
      ended_ms: 0,
      revision: 1,
      markers: [instructor, world.people[3]],
      works: world.attempts
        .filter(({ state }) => state === "scored")
        .slice(0, 4)
        .map((attempt, i) => ({ id: id(910 + i), attempt, marks: [] })),
    },
  ];
  world.annotations = [
    remark(
      700,
      105,
      9_600,
      "Here the bur leans to mesial: keep the handpiece upright while you move along the wall.",
      [2300, 100, 900],
    ),
    remark(701, 105, 30_000, "Good light touch in the corner.", null, true),
    remark(702, 120, 12_000, "Too deep at this point.", [-300, 0, -500]),
  ].map((row) => ({ ...row, author: instructor }));
  world.references = [
    {
      id: id(301),
      exercise_id: id(20),
      attempt_id: id(101),
      dentist: "Dentist One",
      consent: true,
      version: 1,
      created_ms: kStartMs,
      withdrawn_ms: 0,
    },
  ];
  world.jobs = [
    { id: id(40), attempt_id: id(102), state: "failed", tries: 3, error: "The volume of the scene is missing." },
    { id: id(42), attempt_id: id(107), state: "running", progress: 0.35 },
    { id: id(43), attempt_id: id(104), state: "queued", cause: "rescore" },
  ];
  world.audit = makeAudit(world.people);
  world.codes = [{ id: id(401), created_ms: world.nowMs - 10 * kMinuteMs, expires_ms: world.nowMs + 50 * kMinuteMs }];
  world.teeth = [
    { name: "block", summary: "a block with shapes to cut" },
    { name: "molar", summary: "a lower first molar" },
  ];
  world.metrics = kMetrics.map(([name, unit]) => ({ name, unit, title: name }));
  return world;
}

function makePeople() {
  const others = Array.from({ length: 140 }, (_, i) => ({
    login: `student${i + 3}`,
    password: "a long student phrase",
    display_name: `Student ${i + 3}`,
    role: "student",
  }));
  return [...people, ...others].map((person, i) => ({
    id: id(i < people.length ? i + 1 : 995 + i),
    disabled: i === 30,
    must_change_password: i > 100,
    created_ms: kStartMs - 90 * kDayMs,
    revision: 1,
    ...person,
  }));
}

const kMetrics = [
  ["wall_mesial_mm", "mm"],
  ["deviation_rms_mm", "mm"],
  ["floor_mm", "mm"],
  ["force_sent_p95_n", "N"],
  ["time_s", "s"],
  ["task_done_percent", "%"],
  ["zone_container_removed_mm3", "mm3"],
  ["deviation_p95_mm", "mm"],
  ["pulp_exposed_mm2", "mm2"],
];

function makeAssignments({ nowMs, cohorts: [cohort], stations }) {
  const row = (number, exercise, changes) => ({
    id: id(number),
    exercise,
    cohort,
    opens_ms: 0,
    due_ms: 0,
    attempt_limit: 0,
    exam: false,
    late_allowed: false,
    sign_off: false,
    hands: "listed",
    counting: "best",
    stations: [],
    revision: 1,
    created_ms: kStartMs,
    ...changes,
  });
  return [
    row(500, "class-1-occlusal", { opens_ms: nowMs - 10 * kDayMs, due_ms: nowMs + 4 * kDayMs, attempt_limit: 3 }),
    row(501, "class-1-practice", {}),
    row(502, "class-2-mesial", {
      opens_ms: nowMs + 6 * kDayMs,
      due_ms: nowMs + 6 * kDayMs + 90 * kMinuteMs,
      attempt_limit: 1,
      exam: true,
      stations: [stations[0], stations[2]],
    }),
  ];
}

// Newest first. `runs`: how often it was scored.
function makeAttempts({ nowMs, people: all, exercises, stations, profiles: [profile] }) {
  const [student, second, instructor] = all;
  const row = (number, person, exercise, changes = {}) => ({
    id: id(number),
    person,
    exercise: exercises[exercise],
    station: stations[0],
    profile,
    state: "scored",
    score: 80,
    computed_score: changes.score ?? 80,
    critical_fail: false,
    flags: [],
    appeal: null,
    override: null,
    released: false,
    is_reference: false,
    as_reference: false,
    exam: false,
    assignment_id: null,
    recording_removed_ms: 0,
    problem: "",
    problem_field: "",
    gap_ticks: 0,
    hand: { kind: "haptic", device: "omega.3", driver: "hid", unit: "hid:1209:0001:A7" },
    device_origin_um: null,
    progress: 1,
    ticketed_ms: kStartMs + number * 7 * kMinuteMs,
    sealed_ms: kStartMs + number * 7 * kMinuteMs + kMinuteMs,
    ticks: 42_180,
    chunks: 169,
    trace_bytes: 173_214,
    revision: 1,
    runs: 1,
    queued: 0,
    ...changes,
  });
  const unscored = { score: null, computed_score: null, critical_fail: null, progress: 0 };
  const graded = { assignment_id: id(500), due_ms: nowMs + 4 * kDayMs };
  const recording = (number, person, place, changes) =>
    row(number, person, 1, {
      state: "recording",
      ...unscored,
      device_origin_um: [0, 0, 3_000],
      station: stations[place],
      sealed_ms: 0,
      ticks: 12_000,
      ...changes,
    });
  const older = Array.from({ length: 55 }, (_, i) =>
    row(200 + i, second, 1, {
      ticketed_ms: kStartMs - (i + 1) * kDayMs,
      released: true,
      score: Math.round((90 - i * 0.8) * 10) / 10,
      assignment_id: id(501),
    }),
  );
  const crowd = all.slice(5, 23).map((person, i) =>
    row(600 + i, person, 0, {
      ...graded,
      score: 55 + ((i * 17) % 45),
      released: i % 3 === 0,
      ticketed_ms: kStartMs - i * kMinuteMs,
      flags: i === 4 ? ["late"] : i === 6 ? ["faster_than_time", "near_another"] : [],
      stopped: i === 5,
    }),
  );
  return [
    recording(110, student, 0),
    recording(111, second, 2, { exercise: exercises[0], ticks: 430_000 }),
    recording(112, all[8], 3),
    recording(113, all[9], 4),
    row(107, second, 0, { state: "scoring", ...unscored, progress: 0.2, ...graded }),
    row(106, student, 0, graded),
    row(105, student, 1, { released: true, assignment_id: id(501) }),
    row(104, second, 0, { gap_ticks: 412, critical_fail: true, score: 0, ...graded }),
    row(103, second, 0, {
      state: "quarantined",
      ...unscored,
      problem: "chunk 12 came twice with different content",
      problem_field: "contradicted",
    }),
    row(102, student, 0, {
      state: "failed",
      ...unscored,
      problem: "The volume of the scene is missing: restore its blob, then score again.",
    }),
    row(101, instructor, 0, { as_reference: true, is_reference: true, score: 100 }),
    row(120, student, 0, {
      ...graded,
      released: true,
      score: 71.42857142857143,
      flags: ["over_time", "resumed"],
      ticketed_ms: kStartMs - kDayMs,
    }),
    row(121, second, 0, {
      ...graded,
      released: true,
      score: 64.2,
      ticketed_ms: kStartMs - 2 * kDayMs,
      appeal: {
        filed_ms: kStartMs + 2 * kDayMs,
        text: "The mesial wall was cut on purpose: the lesion reached there. Please look at second 20.",
        state: "open",
        answer: "",
        answered_ms: 0,
      },
    }),
    ...crowd,
    ...older,
  ];
}

function remark(number, attempt, tick, text, point, toChair = false) {
  return {
    id: id(number),
    attempt_id: id(attempt),
    tick,
    point_um: point,
    text,
    to_chair: toChair,
    created_ms: kStartMs + 60 * kMinuteMs,
    edited_ms: 0,
    revision: 1,
  };
}

function makeAudit([, , instructor, admin]) {
  const actions = [
    ["attempt.release", instructor, '{"released":false}', '{"released":true}'],
    ["person.edit", admin, '{"role":"student"}', '{"role":"instructor"}'],
    ["attempt.seal", undefined, "", '{"ticks":42180}'],
    ["assignment.add", instructor, "", '{"exercise":"class-1-occlusal","attempt_limit":3}'],
  ];
  return Array.from({ length: 130 }, (_, i) => {
    const [action, person, before, after] = actions[i % actions.length];
    return {
      at_ms: kStartMs - i * 7 * kMinuteMs,
      actor: person === undefined ? "station 1" : `${person.id} (page)`,
      person,
      action,
      object: id(100 + (i % 8)),
      before,
      after,
    };
  });
}
