import assert from "node:assert/strict";
import { test } from "node:test";
import { stoppedEarly } from "../../widgets/attempt_state";
import type { AttemptDetail, Criterion, Score } from "../../api/types";
import {
  byLostPoints,
  failures,
  isWithheld,
  recordingFacts,
  saidFacts,
  summarySentence,
  withheldText,
} from "./summary";

const criterion = (title: string, points: number, max = 10): Criterion => ({
  name: "wall_waviness_mm",
  title,
  value: 0.3,
  unit: "mm",
  points,
  max_points: max,
  reason: "",
});

const score = (changes: Partial<Score> = {}): Score => ({
  score: 83.4,
  critical_fail: false,
  critical: [],
  points: 83.4,
  acceptance: "with_remarks",
  criteria: [criterion("Floor", 10), criterion("Mesial wall", 4), criterion("Time", 8)],
  metrics: [],
  reference_attempt: "",
  rubric_version: 1,
  core_version: 1,
  ticks: 1000,
  gap_ticks: 0,
  late_ticks: 0,
  outages: 0,
  bounded_ticks: 0,
  witness_ok: true,
  witness_note: "",
  ...changes,
});

const attempt = (changes: Partial<AttemptDetail> = {}) => ({ ticks: 1000, gap_ticks: 0, ...changes }) as AttemptDetail;

test("criteria are listed with the most points lost first, full marks last", () => {
  assert.deepEqual(
    byLostPoints(score().criteria).map((item) => item.title),
    ["Mesial wall", "Time", "Floor"],
  );
});

test("what fails an attempt is an error of the list, or a criterion beyond its own limit", () => {
  const critical: Score["critical"] = [
    {
      error: "pulp_exposed",
      name: "pulp_exposed_mm2",
      value: 0.1,
      unit: "mm2",
      limit: 0,
      above: true,
      reason: "The pulp is exposed.",
    },
  ];
  const beyond: Criterion = {
    ...criterion("Mesial wall", 0),
    reason: "0.36 mm.",
    reasons: [{ code: "fails_above", values: [0.36, 0.2], units: ["mm", "mm"] }],
  };
  assert.deepEqual(failures(score()), []);
  assert.deepEqual(failures(score({ critical, criteria: [criterion("Floor", 10), beyond] })), [
    "The pulp is exposed.",
    "Mesial wall: 0.36 mm.",
  ]);
});

test("the sentence names the score and where most points went", () => {
  const text = summarySentence(score());
  assert.match(text, /^83\.4 of 100\./);
  assert.match(text, /“Mesial wall” \(0\.30\u00a0mm, −6 of 30 points\), then on “Time”/);
  assert.match(text, /Full marks in 1 of 3 criteria\.$/);
});

test("full marks and a critical fail are named", () => {
  assert.match(
    summarySentence(score({ score: 100, criteria: [criterion("Floor", 10)] })),
    /Full marks in every criterion/,
  );
  assert.match(summarySentence(score({ score: 0, critical_fail: true })), /^Not acceptable, so the score is 0/);
});

test("work that was stopped early is said before anything else", () => {
  const gate: NonNullable<Score["gates"]>[number] = {
    name: "task_done_percent",
    title: "Task done",
    value: 43,
    unit: "%",
    share: 0.45,
    reason: "",
  };
  assert.match(summarySentence(score({ score: 31, gates: [gate] })), /^31\.0 of 100\. Only 43 % of the task was done/);
  assert.match(summarySentence(score({ gates: [{ ...gate, share: 1 }] })), /Mesial wall/);
  assert.equal(stoppedEarly({ gates: [gate] }), 43);
  const caries = { ...gate, name: "caries_left_percent" as const, value: 30 };
  assert.equal(stoppedEarly({ gates: [caries] }), undefined, "ended, and left it");
  assert.match(summarySentence(score({ score: 31, gates: [caries] })), /^31\.0 of 100\. 30 % of the caries was left/);
  assert.equal(stoppedEarly({ gates: [{ ...gate, name: "damage_percent" }] }), undefined);
});

test("a criterion that is not in the exercise is not counted", () => {
  const unjudged = { ...criterion("Caries", 0, 0), judged: false };
  const text = summarySentence(score({ criteria: [criterion("Floor", 10), criterion("Time", 8), unjudged] }));
  assert.match(text, /Full marks in 1 of 2 criteria\.$/);
});

test("a recording without gaps whose replay agrees is complete", () => {
  const facts = recordingFacts(attempt(), score());
  assert.equal(facts.complete, true);
  assert.deepEqual(facts.details, []);
});

test("gaps, a broken replay and late ticks are each said, with how many", () => {
  const facts = recordingFacts(
    attempt({ gap_ticks: 10 }),
    score({ gap_ticks: 10, ticks: 990, witness_ok: false, witness_note: "chunk 12", late_ticks: 1 }),
  );
  assert.equal(facts.complete, false);
  assert.match(facts.details.join("\n"), /Not recorded: 10 ticks \(1 %\)/);
  assert.match(facts.details.join("\n"), /does not match the station’s recording: chunk 12/);
  assert.match(facts.details.join("\n"), /1 tick was late/);
});

test("how often the force was taken away is said by the hour", () => {
  const details = (outages: number) => recordingFacts(attempt({ duration_s: 720 }), score({ outages })).details;
  assert.deepEqual(details(0), []);
  assert.deepEqual(details(3), ["The force was interrupted 3 times by the device or the station (15 an hour)."]);
});

test("a disturbed attempt is said with its figures, an undisturbed one is not", () => {
  const details = (disturbed: boolean) =>
    recordingFacts(
      attempt(),
      score({ disturbance: { disturbed, late_percent: 2.5, gap_percent: 0, limited_percent: 0.04 } }),
    ).details;
  assert.deepEqual(details(true), [
    "The station disturbed the attempt: 2.5 % of its ticks were late, 0 % of the time is missing, and the device was at its limit for 0 % of the time with force.",
  ]);
  assert.deepEqual(details(false), []);
});

test("before the score is known only what the attempt itself says is claimed", () => {
  assert.equal(recordingFacts(attempt(), undefined).headline, "Nothing was lost");
  assert.equal(recordingFacts(attempt({ gap_ticks: 3 }), undefined).complete, false);
});

test("facts are shown by their names when they were said, also those that this page does not know", () => {
  assert.deepEqual(saidFacts({ resumed: 0 }), []);
  assert.deepEqual(saidFacts({}), []);
  const later = { resumed: 2, chair_side: "left <b>", gloves: true, mask: false, lamp: "", list: [1], nothing: null };
  assert.deepEqual(saidFacts(later), [
    { name: "Resumed", value: "2" },
    { name: "Chair side", value: "left <b>" },
    { name: "Gloves", value: "Yes" },
  ]);
});

test("a scored attempt without a score to be seen waits for its release, for the student alone", () => {
  const hidden = { state: "scored", computed_score: null } as const;
  assert.equal(isWithheld(hidden, false), true);
  assert.equal(isWithheld(hidden, true), false);
  assert.equal(isWithheld({ ...hidden, computed_score: 80 }, false), false);
  assert.equal(isWithheld({ ...hidden, state: "failed" }, false), false);
  assert.match(withheldText({ exam: true }), /exam is scored.*once your instructor releases/);
});
