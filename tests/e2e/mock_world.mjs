// What the mock server remembers: as much of invented people, things and attempts as the flows look
// at. The contract's samples stand for the rest. Rows name each other by reference; an answer has
// as much of them as the contract says.
import { golden } from "./contract.mjs";

export const id = (number) => `00000000-0000-7000-8000-${String(number).padStart(12, "0")}`;
const kMinuteMs = 60_000,
  kDayMs = 1440 * kMinuteMs;
const kStartMs = Date.UTC(2026, 2, 9, 9, 0);

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

// metric, title, unit, points, map, and of every attempt: value, points, why
const kRubric = [
  [
    "deviation_rms_mm",
    "Shape against the reference",
    "mm",
    25,
    [
      [0.05, 1],
      [0.3, 0],
    ],
    0.098,
    20.2,
    "The surface lies 0.098 mm (RMS) from the reference; full marks up to 0.05 mm, none from 0.3 mm.",
  ],
  [
    "wall_mesial_mm",
    "Mesial wall",
    "mm",
    15,
    [
      [0.1, 1],
      [0.4, 0],
    ],
    0.301,
    4.9,
    "The mesial wall was cut 0.301 mm too far; full marks up to 0.1 mm, none from 0.4 mm.",
  ],
  [
    "target_removed_percent",
    "Target removed",
    "%",
    20,
    [
      [80, 0],
      [98, 1],
    ],
    99.1,
    20,
    "99.1 % of the target was removed; full marks from 98 %.",
  ],
  [
    "container_removed_mm3",
    "Sound tissue kept",
    "mm3",
    20,
    [
      [0.1, 1],
      [3, 0],
    ],
    0.84,
    14.9,
    "0.84 mm³ were removed that must stay; full marks up to 0.1 mm³.",
  ],
  [
    "force_sent_p95_n",
    "Gentle force",
    "N",
    10,
    [
      [1.5, 1],
      [3, 0],
    ],
    1.31,
    10,
    "95 % of the sent force stays below 1.31 N; full marks up to 1.5 N.",
  ],
  [
    "duration_s",
    "Time",
    "s",
    10,
    [
      [120, 1],
      [300, 0],
    ],
    42.2,
    10,
    "Done in 42 s; full marks up to 120 s.",
  ],
];

function makeExercises() {
  const rubric = {
    name: "class-1",
    version: 1,
    criteria: kRubric.map(([metric, title, unit, points, map]) => ({
      metric,
      title,
      unit,
      points,
      fails_above: metric === "container_removed_mm3" ? 8 : null,
      map: map.map(([value, share]) => ({ value, share })),
    })),
    gates: [
      {
        metric: "task_done_percent",
        title: "Task done",
        unit: "%",
        comment: "The work was stopped early.",
        map: [
          { value: 5, share: 0 },
          { value: 90, share: 1 },
        ],
      },
    ],
  };
  const target = {
    landmark: "central_fossa",
    landmark_um: [0, 0, 0],
    half_size_um: [2100, 1350, 0],
    depth_um: 2000,
    leeway_side_um: 200,
    leeway_bottom_um: 200,
    container_um: 800,
  };
  const disc = { outline: "disc", top_um: [0, 0, 0], radius_um: 1350, depth_um: 2000 };
  const exercise = (number, name, title, graded, instructions, changes = {}) => ({
    id: id(number),
    name,
    title,
    version: 1,
    state: "published",
    revision: 1,
    published_ms: kStartMs - 30 * kDayMs,
    graded,
    instructions,
    time_limit_s: graded ? 600 : 0,
    has_reference: true,
    shared: true,
    owner: null,
    bur: { shape: "cylinder", radius_um: 500, length_um: 4000, shank_radius_um: 800, neck_um: 2000 },
    law: "maxwell",
    rate_hz: 1000,
    target: { ...target, parts: graded ? [] : [disc] },
    rubric,
    ...changes,
  });
  return [
    exercise(
      20,
      "class-1-occlusal",
      "Occlusal cavity, class I",
      true,
      "Cut a box cavity in the occlusal surface of the lower first molar.\nKeep the walls upright and the floor flat. Stay out of the marginal ridges.",
    ),
    exercise(
      21,
      "class-1-practice",
      "Occlusal cavity, practice",
      false,
      "The same cavity without a grade. The score shows as soon as you are done.",
      { version: 2 },
    ),
    exercise(
      22,
      "class-2-mesial",
      "Class II cavity, mesial box",
      true,
      "Cut the mesial box: 3.2 mm wide, 3.5 mm deep from the marginal ridge, its axial wall 0.99 mm inside the middle of the ridge, open to the mesial side. Do not touch the neighbour.",
    ),
    exercise(23, "crown", "Crown preparation", true, "Reduce the crown evenly.", {
      state: "draft",
      version: 0,
      has_reference: false,
    }),
    exercise(24, "cross", "Cross in a block", false, "Cut the cross.", { state: "retired" }),
  ];
}

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
    gap_ticks: 0,
    hand: { kind: "haptic", device: "omega.3", driver: "hid", unit: "hid:1209:0001:A7" },
    progress: 1,
    ticketed_ms: kStartMs + number * 7 * kMinuteMs,
    sealed_ms: kStartMs + number * 7 * kMinuteMs + kMinuteMs,
    ticks: 42_180,
    chunks: 169,
    trace_bytes: 173_214,
    revision: 1,
    runs: 1,
    ...changes,
  });
  const unscored = { score: null, computed_score: null, critical_fail: null, progress: 0 };
  const graded = { assignment_id: id(500), due_ms: nowMs + 4 * kDayMs };
  const recording = (number, person, place, changes) =>
    row(number, person, 1, {
      state: "recording",
      ...unscored,
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
      problem: "Chunk 12 was received twice with different content. Both are kept.",
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

export const kReference = { attempt_id: id(101), dentist: "Dentist One" };

export function scoreOf(row) {
  const perfect = row.as_reference;
  const strokes = [
    [7, 21_400, 0.9],
    [8, 23_100, 0.4],
    [9, 24_800, 0.12],
  ].map(([number, tick, volume]) => ({ number, first_tick: tick, first_s: tick / 1000, volume_mm3: volume }));
  const gate =
    row.stopped === true
      ? {
          value: 46,
          share: 0.48,
          reason:
            "Task done: 46.0 % (full marks from 90.0 %, none up to 5.0 %). Every criterion keeps 48.0 % of its points.",
        }
      : { value: 98.2, share: 1, reason: "Task done: 98.2 % (full marks from 90.0 %)." };
  return {
    score: row.critical_fail ? 0 : perfect ? 100 : (row.computed_score ?? 80),
    critical_fail: row.critical_fail === true,
    criteria: kRubric.map(([name, title, unit, most, , value, points, reason]) => ({
      name,
      title,
      unit,
      value,
      points: perfect ? most : points,
      max_points: most,
      reason,
      judged: true,
    })),
    gates: [{ name: "task_done_percent", title: "Task done", unit: "%", ...gate }],
    missing: [{ name: "caries_left_mm3", why: "not_in_task" }],
    metrics: kRubric.map(([name, , unit, , , value]) => ({ name, value, unit })),
    deductions: perfect
      ? []
      : [
          {
            criterion: "wall_mesial_mm",
            left: false,
            volume_mm3: 1.42,
            position_mm: [1.6, 0, -1],
            facing: [-1, 0, 0],
            first_tick: 21_400,
            first_s: 21.4,
            stroke_count: 3,
            strokes,
          },
        ],
    envelope: perfect
      ? null
      : {
          references: [
            { attempt: kReference.attempt_id, overlap_percent: 93.4 },
            { attempt: id(102), overlap_percent: 90.1 },
            { attempt: id(103), overlap_percent: 89.7 },
          ],
          left_of_all_mm3: 0.31,
          disputed_mm3: 1.9,
          taken_by_mm3: [1.2, 0.4, 0.9, 23.3],
          metrics: [
            {
              name: "wall_mesial_mm",
              unit: "mm",
              least: -0.04,
              median: 0,
              most: 0.11,
              spread: 0.059,
              z: 5.1,
              percentile: 100,
            },
            {
              name: "duration_s",
              unit: "s",
              least: 38.2,
              median: 61,
              most: 95.4,
              spread: 33.8,
              z: -0.6,
              percentile: 33.3,
            },
          ],
        },
    reference_attempt: kReference.attempt_id,
    rubric_version: 1,
    core_version: 1,
    ticks: row.ticks,
    gap_ticks: row.gap_ticks,
    late_ticks: row.gap_ticks > 0 ? 7 : 0,
    witness_ok: row.gap_ticks === 0,
    witness_note: row.gap_ticks === 0 ? "" : "the state after chunk 12 differs",
  };
}

function makeProfiles() {
  const profile = (name, title, coupling, calibrations = []) => {
    const document = {
      ...golden("scene_profile_phantom_desktop"),
      name,
      title,
      coupling_mn_per_mm: { value: coupling, source: "measured" },
    };
    const numbers = Object.entries(document)
      .filter(([, each]) => each.source !== undefined)
      .map(([member, each]) => ({ name: member, ...each }));
    const versions = [2, 1].map((version) => ({ version, title, content: "ab".repeat(32), created_ms: kStartMs }));
    return {
      name,
      title,
      version: 2,
      created_ms: kStartMs,
      coupling,
      document,
      numbers,
      acceptable: true,
      criteria: criteriaOf(coupling),
      calibrations,
      versions,
      reports: [{ id: id(801), version: 2, bytes: 48_210, created_ms: kStartMs }],
    };
  };
  const worn = [1.18, 1.15, 1.12, 1.06, 1].map((factor, i) => {
    const document = {
      ...golden("scene_calibration"),
      device: "hid:0451:bef3 serial 1042",
      measured_ms: kStartMs - (i + 1) * 30 * kDayMs,
    };
    const measured = Object.fromEntries(
      Object.entries(document.measured).map(([name, each]) => [
        name,
        { ...each, value: Math.round(each.value * factor) },
      ]),
    );
    return { ...document, id: id(820 + i), added_ms: document.measured_ms, document: { ...document, measured } };
  });
  return [profile("phantom_desktop", "Phantom Desktop", 1200, worn), profile("omega_6", "Omega 6", 20_000)];
}

export function criteriaOf(couplingMnPerMm) {
  const criterion = (name, title, formula, value, limit) => ({
    name,
    title,
    formula,
    unit: "mN/mm",
    value,
    limit,
    met: value <= limit,
  });
  return [
    criterion("coupling_damping", "Passive limit of the coupling", "Kc <= 2 b / (T (d + 1)^2)", couplingMnPerMm, 1760),
    criterion("coupling_stiffness", "Largest stiffness the device shows", "Kc <= K", couplingMnPerMm, 1860),
  ];
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
