// Exercises of the mock server with their rubric and its scores, and device profiles.
import { golden } from "./contract.mjs";

export const id = (number) => `00000000-0000-7000-8000-${String(number).padStart(12, "0")}`;
export const kMinuteMs = 60_000,
  kDayMs = 1440 * kMinuteMs;
export const kStartMs = Date.UTC(2026, 2, 9, 9, 0);

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
    "Sound tissue preserved",
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

export function makeExercises() {
  const rubric = {
    name: "class-1",
    version: 1,
    restoration: null,
    criteria: kRubric.map(([metric, title, unit, points, map]) => ({
      metric,
      title,
      unit,
      points,
      fails_above: metric === "container_removed_mm3" ? 8 : null,
      map: map.map(([value, share]) => ({ value, share })),
    })),
    critical: [
      { error: "nothing_cut", metric: "task_done_percent", unit: "%", limit: 5, above: false, source: "chosen" },
      { error: "pulp_exposed", metric: "pulp_exposed_mm2", unit: "mm2", limit: 0, above: true, source: "ADEX" },
    ],
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
    tooth: 36,
    up: "occlusal",
    landmark_um: [0, 0, 0],
    half_size_um: [2100, 1350, 0],
    depth_um: 2000,
    leeway_side_um: 200,
    leeway_bottom_um: 200,
    container_um: 800,
  };
  // A class I or class II cavity is for a filling.
  const filled = {
    ...rubric,
    restoration: {
      name: "amalgam",
      source: "a textbook",
      divergence_deg: { mesiodistal: [-2, 10], buccolingual: [-5, 2] },
    },
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
    burs: [
      {
        shape: "cylinder",
        radius_um: 500,
        length_um: 4000,
        narrow_radius_um: 0,
        shank_radius_um: 800,
        neck_um: 2000,
        iso_number: "",
      },
      {
        shape: "pear",
        radius_um: 600,
        length_um: 2500,
        narrow_radius_um: 350,
        shank_radius_um: 0,
        neck_um: 0,
        iso_number: "806 314 237 524 012",
      },
    ],
    law: "maxwell",
    rate_hz: 1000,
    rubber_dam: false,
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
      { rubric: filled },
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
      "Cut the mesial box 3.2 mm wide and 3.5 mm deep from the marginal ridge, open to the mesial side, with its axial wall 0.99 mm inside the middle of the ridge. Do not touch the adjacent tooth.",
      { rubric: filled },
    ),
    exercise(23, "crown", "Crown preparation", true, "Reduce the crown evenly.", {
      state: "draft",
      version: 0,
      has_reference: false,
    }),
    exercise(24, "cross", "Cross in a block", false, "Cut the cross.", { state: "retired" }),
  ];
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
    points: perfect ? 100 : (row.computed_score ?? 80),
    acceptance: row.critical_fail ? "not_acceptable" : perfect ? "acceptable" : "with_remarks",
    critical: row.critical_fail
      ? [
          {
            error: "pulp_exposed",
            name: "pulp_exposed_mm2",
            value: 0.42,
            unit: "mm2",
            limit: 0,
            above: true,
            reason: "The pulp is exposed (0.42 mm2, at most 0.00 mm2).",
          },
        ]
      : [],
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
    outages: row.gap_ticks > 0 ? 2 : 0,
    witness_ok: row.gap_ticks === 0,
    witness_note: row.gap_ticks === 0 ? "" : "the state after chunk 12 differs",
  };
}

// A member of the document as the server's list of numbers has it.
function numberOf(member) {
  const [, name, unit] = /^(.*?)(?:_(mn_per_mm|mn_s_per_m|nm|um|mn|g|hz|ticks))?$/.exec(member);
  if (unit === undefined) return { name, unit: "" };
  return { name, unit: unit.replace("_per_", "/").replace("_s/", " s/").replace("mn", "mN").replace("hz", "Hz") };
}

export function makeProfiles() {
  const profile = (name, title, coupling, calibrations = []) => {
    const document = {
      ...golden("scene_profile_phantom_desktop"),
      name,
      title,
      coupling_mn_per_mm: { value: coupling, source: "measured" },
    };
    const numbers = Object.entries(document)
      .filter(([, each]) => each.source !== undefined)
      .map(([member, each]) => ({ ...numberOf(member), ...each }));
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
    criterion(
      "coupling_damping",
      "Passivity limit of the coupling",
      "Kc <= 2 b / (T (d + 1)^2)",
      couplingMnPerMm,
      1760,
    ),
    criterion("coupling_stiffness", "Largest stiffness the device shows", "Kc <= K", couplingMnPerMm, 1860),
  ];
}
