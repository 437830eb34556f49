// @ts-check
// What the mock server knows: invented people and attempts in the shapes of schemas/api/openapi.yaml.
import { toolPosition } from "./mock_tooth.mjs";

/** @typedef {import("../../web/build/api").components["schemas"]} Schemas */

export const id = (number) => `00000000-0000-7000-8000-${String(number).padStart(12, "0")}`;
export const kStartMs = Date.UTC(2026, 2, 9, 9, 0);
export const kMinuteMs = 60_000;
export const kDayMs = 1440 * kMinuteMs;

export const people = [
  { id: id(1), login: "student", password: "a long student phrase", display_name: "Student One", role: "student" },
  { id: id(2), login: "student2", password: "a long student phrase", display_name: "Student Two", role: "student" },
  { id: id(3), login: "instructor", password: "a long instructor phrase", display_name: "Instructor One", role: "instructor" },
  { id: id(4), login: "admin", password: "a long admin phrase", display_name: "Admin One", role: "admin" },
  { id: id(5), login: "newcomer", password: "given by the office", display_name: "Newcomer One", role: "student" },
];

/** @type {[string, string, string, number, [number, number][]][]} */
const rubric = [
  ["deviation_rms_mm", "Shape against the reference", "mm", 25, [[0.05, 1], [0.3, 0]]],
  ["wall_mesial_mm", "Mesial wall", "mm", 15, [[0.1, 1], [0.4, 0]]],
  ["target_removed_percent", "Target removed", "%", 20, [[80, 0], [98, 1]]],
  ["container_removed_mm3", "Sound tissue kept", "mm3", 20, [[0.1, 1], [3, 0]]],
  ["force_sent_p95_n", "Gentle force", "N", 10, [[1.5, 1], [3, 0]]],
  ["duration_s", "Time", "s", 10, [[120, 1], [300, 0]]],
];

export function exerciseRows() {
  return [
    exercise(20, "class-1-occlusal", "Occlusal cavity, class I", true,
             "Cut a box cavity in the occlusal surface of the lower first molar.\nKeep the walls upright and the floor flat. Stay out of the marginal ridges.", 1),
    exercise(21, "class-1-practice", "Occlusal cavity, practice", false, "The same cavity without a grade. The score shows as soon as you are done.", 2),
    exercise(22, "class-2-mesial", "Class II cavity, mesial box", true,
             "Cut the mesial box: 3.2 mm wide, 3.5 mm deep from the marginal ridge, its axial wall 0.99 mm inside the middle of the ridge, open to the mesial side. Do not touch the neighbour.", 1),
    { ...exercise(23, "crown", "Crown preparation", true, "Reduce the crown evenly.", 0), state: "draft", has_reference: false },
    { ...exercise(24, "cross", "Cross in a block", false, "Cut the cross.", 1), state: "retired" },
  ];
}

/** @returns {Omit<Schemas["Exercise"], "my_attempts"> & Record<string, unknown>} */
function exercise(number, name, title, graded, instructions, version) {
  return {
    id: id(number), name, title, version, state: "published", revision: 1, published_ms: kStartMs - 30 * kDayMs, graded, instructions, time_limit_s: graded ? 600 : 0,
    bur: { shape: "cylinder", radius_um: 500, length_um: 4000, narrow_radius_um: 0, shank_radius_um: 800, neck_um: 2000 }, has_reference: true, owner: null, shared: true, may: [],
    law: "maxwell", rate_hz: 1000, handpiece: graded ? { stall_un_m: 2500, tangential_permille: 300, lag_us: 40_000 } : null,
    touch_cues: graded ? null : { contact_mn: 250, chatter_mn: 100, energy_uj: 200, power_uw: 1000 },
    scene_sha256: "5c".repeat(32), document_sha256: "d0".repeat(32),
    target: { landmark: "central_fossa", landmark_um: [0, 0, 0], half_size_um: [2100, 1350, 0], depth_um: 2000, leeway_side_um: 200, leeway_bottom_um: 200, container_um: 800, parts: graded ? [] : [{ outline: "disc", top_um: [0, 0, 0], radius_um: 1350, depth_um: 2000 }] },
    rubric: { name: "class-1", version: 1, criteria: rubric.map(([metric, criterion, unit, points, map]) => ({
      metric, title: criterion, unit, points, comment: "", fails_above: metric === "container_removed_mm3" ? 8 : null, map: map.map(([value, share]) => ({ value, share })) })),
      gates: [{ metric: "task_done_percent", title: "Task done", unit: "%", comment: "The work was stopped early.", map: [{ value: 5, share: 0 }, { value: 90, share: 1 }] }] },
  };
}

const kTitles = [["20", "Occlusal cavity, class I"], ["21", "Occlusal cavity, practice"]];

// With what only the detail has (`appeal`, `override`) already in it.
/** @returns {Schemas["Attempt"] & Pick<Schemas["AttemptDetail"], "override" | "appeal"> & { runs: number }} */
export function attemptRow(number, person, exerciseIndex, changes = {}) {
  const [exerciseNumber, title] = kTitles[exerciseIndex];
  const score = changes.score === undefined ? 80 : changes.score;
  return {
    id: id(number), person: { id: person.id, display_name: person.display_name }, exercise: { id: id(Number(exerciseNumber)), title },
    station: { id: id(30), name: "Station 1" }, profile: { name: "phantom_desktop", title: "Phantom Desktop" },
    state: "scored", as_reference: false, is_reference: false, released: false, score, computed_score: score, assignment_id: null, exam: false, due_ms: 0, flags: [], facts: { resumed: 0 }, hand: { kind: "haptic", device: "omega.3", driver: "hid", unit: "hid:1209:0001:A7" },
    critical_fail: false, progress: 1, ticketed_ms: kStartMs + number * 7 * kMinuteMs, sealed_ms: kStartMs + number * 7 * kMinuteMs + kMinuteMs, ticks: 42_180,
    gap_ticks: 0, chunks: 169, trace_bytes: 173_214, problem: "", recording_removed_ms: 0, revision: 1, override: null, appeal: null, runs: 1, ...changes,
  };
}

export function appealOf(text) {
  return { filed_ms: kStartMs + 2 * kDayMs, text, state: "open", answer: "", answered_ms: 0 };
}

export const referenceDetail = { attempt_id: id(101), dentist: "Dentist One" };

/** @returns {Schemas["Score"]} */
export function scoreOf(row) {
  const perfect = row.as_reference;
  const criterion = (index, value, points, reason) => {
    const [name, title, unit, max] = rubric[index];
    return { name, title, value, unit, points: perfect ? max : points, max_points: max, reason, judged: true };
  };
  return {
    score: row.critical_fail ? 0 : perfect ? 100 : row.computed_score ?? 80, critical_fail: row.critical_fail === true,
    criteria: [
      criterion(0, 0.098, 20.2, "The surface lies 0.098 mm (RMS) from the reference; full marks up to 0.05 mm, none from 0.3 mm."),
      criterion(1, 0.301, 4.9, "The mesial wall was cut 0.301 mm too far; full marks up to 0.1 mm, none from 0.4 mm."),
      criterion(2, 99.1, 20, "99.1 % of the target was removed; full marks from 98 %."),
      criterion(3, 0.84, 14.9, "0.84 mm³ were removed that must stay; full marks up to 0.1 mm³."),
      criterion(4, 1.31, 10, "95 % of the sent force stays below 1.31 N; full marks up to 1.5 N."),
      criterion(5, 42.2, 10, "Done in 42 s; full marks up to 120 s."),
    ],
    gates: [row.stopped === true
      ? { name: "task_done_percent", title: "Task done", value: 46, unit: "%", share: 0.48, reason: "Task done: 46.0 % (full marks from 90.0 %, none up to 5.0 %). Every criterion keeps 48.0 % of its points." }
      : { name: "task_done_percent", title: "Task done", value: 98.2, unit: "%", share: 1, reason: "Task done: 98.2 % (full marks from 90.0 %)." }],
    missing: [{ name: "caries_left_mm3", why: "not_in_task" }],
    metrics: /** @type {[string, number, string][]} */ ([
      ["deviation_rms_mm", 0.098, "mm"], ["deviation_p95_mm", 0.292, "mm"], ["wall_mesial_mm", 0.301, "mm"], ["wall_distal_mm", -0.088, "mm"],
      ["target_removed_percent", 99.1, "%"], ["leeway_removed_percent", 31.4, "%"], ["container_removed_mm3", 0.84, "mm3"],
      ["removed_enamel_mm3", 19.82, "mm3"], ["removed_dentin_mm3", 4.91, "mm3"], ["removed_pulp_mm3", 0, "mm3"], ["pulp_exposed", 0, "count"],
      ["force_sent_p95_n", 1.31, "N"], ["force_sent_max_n", 2.04, "N"], ["anchor_path_m", 0.412, "m"], ["duration_s", 42.18, "s"],
      ["dtw_pose_mm", 0.36, "mm"], ["dtw_force_n", 0.21, "N"],
    ]).map(([name, value, unit]) => ({ name, value, unit })),
    deductions: perfect ? [] : [{
      criterion: "wall_mesial_mm", left: false, volume_mm3: 1.42, position_mm: [1.6, 0, -1], facing: [-1, 0, 0], first_tick: 21_400, first_s: 21.4,
      stroke_count: 3, strokes: [[7, 21_400, 0.9], [8, 23_100, 0.4], [9, 24_800, 0.12]].map(([number = 0, tick = 0, volume = 0]) => ({ number, first_tick: tick, first_s: tick / 1000, volume_mm3: volume })),
    }],
    envelope: perfect ? null : {
      references: [{ attempt: referenceDetail.attempt_id, overlap_percent: 93.4 }, { attempt: id(102), overlap_percent: 90.1 }, { attempt: id(103), overlap_percent: 89.7 }],
      left_of_all_mm3: 0.31, disputed_mm3: 1.9, taken_by_mm3: [1.2, 0.4, 0.9, 23.3],
      metrics: [{ name: "wall_mesial_mm", unit: "mm", least: -0.04, median: 0, most: 0.11, spread: 0.059, z: 5.1, percentile: 100 },
                { name: "time_s", unit: "s", least: 38.2, median: 61, most: 95.4, spread: 33.8, z: -0.6, percentile: 33.3 }],
    },
    reference_attempt: referenceDetail.attempt_id, rubric_version: 1, scoring_version: 2, core_version: 1, ticks: row.ticks, gap_ticks: row.gap_ticks,
    late_ticks: row.gap_ticks > 0 ? 7 : 0, bounded_ticks: 0, witness_ok: row.gap_ticks === 0,
    witness_note: row.gap_ticks === 0 ? "" : "the state after chunk 12 differs",
  };
}

const kSeriesSteps = 1800;
const kStepTicks = 24;
export const seriesEndS = () => kSeriesSteps * kStepTicks / 1000;

const kHeldBackFromN = 1.3, kLateStep = 140;
// Who begins slowly and then hurries: the same work, its share after a share of the time raised to this.
const kPaces = new Map([[id(201), 1.5]]);
export const paceOf = (attempt) => kPaces.get(attempt) ?? 1;

/** @returns {Schemas["Series"]} */
export function seriesOf(pace = 1) {
  const steps = kSeriesSteps;
  const random = seeded(7);
  const series = { rate_hz: 1000, step_ticks: kStepTicks, t_s: numbers(), force_n: numbers(), force_mean_n: numbers(), bound_n: numbers(),
                   removed_mm3: numbers(), removed_by_tissue: { enamel: numbers(), dentin: numbers() },
                   anchor_mm: /** @type {[number, number, number][]} */ ([]), force_vector_n: /** @type {[number, number, number][]} */ ([]),
                   computed_n: numbers(), late_ticks: numbers(), pulp_mm: numbers() };
  let removed = 0;
  let drift = 0;
  for (let i = 0; i < steps; ++i) {
    const share = (i / (steps - 1)) ** pace;
    const contact = share > 0.03 && share < 0.97 && Math.sin(share * 44) > -0.82;
    drift = 0.96 * drift + 0.06 * (random() - 0.5);
    const mean = contact ? Math.max(0.05, 0.72 + 0.35 * Math.sin(share * 21) + 1.4 * drift) : 0.01;
    const largest = mean * (1.1 + 0.35 * random());
    removed += contact ? (24.73 / (steps * 0.86)) * (0.7 + 0.6 * random()) : 0;
    series.t_s.push(Math.round(i * kStepTicks) / 1000);
    series.force_n.push(round(largest));
    series.force_mean_n.push(round(mean));
    series.bound_n.push(7.9);
    const lean = 0.5 * Math.sin(share * 30);
    series.force_vector_n.push([round(largest * Math.sin(lean)), 0, round(largest * Math.cos(lean))]);
    series.computed_n.push(round(largest > kHeldBackFromN ? largest + 0.4 : largest));
    series.late_ticks.push(i === kLateStep ? 3 : 0);
    series.removed_mm3.push(round(removed));
    series.removed_by_tissue.enamel.push(round(removed * 0.8));
    series.removed_by_tissue.dentin.push(round(removed * 0.2));
    const [x, y, z] = toolPosition(share);
    series.anchor_mm.push([round(x), round(y), round(contact ? z : z + 2.5)]);
    series.pulp_mm.push(round(Math.min(5, Math.hypot(x, y, (contact ? z : z + 2.5) + 4.5))));
  }
  return series;
}

// Ticks of the recording: a trembling force, held back at its peaks, and a gap of 50 ticks at each full second.
export function ticksOf(from, to) {
  const ticks = { from, to, time_ticks: numbers(), force_n: numbers(), computed_n: numbers(), late: numbers(), limited: numbers() };
  for (let time = from; time < Math.min(to, 1000 * seriesEndS()); ++time) {
    if (time % 1000 < 50) continue;
    const force = 0.9 + 0.3 * Math.sin(time / 16) + 0.1 * Math.sin(time / 3);
    const held = force > 1.2;
    ticks.time_ticks.push(time);
    ticks.force_n.push(round(held ? 1.2 : force));
    ticks.computed_n.push(round(force));
    ticks.late.push(0);
    ticks.limited.push(held ? 1 : 0);
  }
  return ticks;
}

function numbers() {
  return /** @type {number[]} */ ([]);
}

function round(value) {
  return Math.round(value * 1000) / 1000;
}

function seeded(seed) {
  let state = seed;
  return () => {
    state = (state * 1664525 + 1013904223) >>> 0;
    return state / 2 ** 32;
  };
}
