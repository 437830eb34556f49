import assert from "node:assert/strict";
import { test } from "node:test";
import { cariesLeft, stoppedEarly } from "../../widgets/attempt_state";
import type { AttemptDetail, Criterion, Mistake, Region, Score } from "../../api/types";
import { failures, groupsOf, isWithheld, recordingFacts, saidFacts, summarySentence, withheldText } from "./summary";

const group = (name: "outline" | "internal_form" | "margins", lost: number, changes: Partial<Criterion> = {}) =>
  ({ ...criterion(lost), name, group: name, title: name, ...changes }) satisfies Criterion;

const criterion = (lost: number, changes: Partial<Criterion> = {}): Criterion => ({
  name: "force_sent_p95_n",
  group: "hand",
  title: "Light hand",
  value: 1.3,
  unit: "N",
  lost,
  most: 10,
  state: "acceptable",
  judged: true,
  reason: "",
  ...changes,
});

const region = (name: Region["name"], lost: number, changes: Partial<Region> = {}): Region => ({
  name,
  kind: "wall",
  group: "outline",
  over: 0.3,
  left: 0,
  unit: "mm",
  uncertainty: 0.01,
  dearer: "over",
  lost,
  state: "acceptable",
  ...changes,
});

const mistake = (changes: Partial<Mistake>): Mistake => ({
  kind: "over_extended",
  place: "wall_distal",
  size: 0.3,
  unit: "mm",
  points: 9,
  group: "outline",
  at_mm: [1, 0, 0],
  towards: [0, 0, 0],
  ...changes,
});

const score = (changes: Partial<Score> = {}): Score => ({
  score: 83.4,
  critical_fail: false,
  critical: [],
  borderline: [],
  board: [],
  points_uncertainty: 0.3,
  points: 83.4,
  acceptance: "with_remarks",
  criteria: [group("outline", 4.5), group("internal_form", 0.02), group("margins", 10), criterion(2.1)],
  regions: [],
  mistakes: [],
  beyond: 0,
  metrics: [],
  deductions: [],
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

test("a group has its regions, the dearest first, and the state of its worst part", () => {
  const [outline, hand] = groupsOf({
    criteria: [group("outline", 7, { state: "modify" }), criterion(1), criterion(3, { name: "time_s", state: "redo" })],
    regions: [region("wall_mesial", 2), region("wall_distal", 5), region("floor", 9, { group: "internal_form" })],
  });
  assert.deepEqual([outline?.title, outline?.lost, outline?.state], ["Outline", 7, "modify"]);
  assert.deepEqual(
    outline?.regions.map(({ name }) => name),
    ["wall_distal", "wall_mesial"],
  );
  assert.deepEqual(outline?.criteria, []);
  assert.deepEqual([hand?.title, hand?.lost, hand?.state], ["Hand", 4, "redo"]);
  assert.deepEqual(
    hand?.criteria.map(({ name }) => name),
    ["time_s", "force_sent_p95_n"],
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
      uncertainty: 0,
      reason: "The pulp is exposed.",
    },
  ];
  const beyond = criterion(10, {
    reason: "As the server says.",
    reasons: [{ code: "fails_above", values: [2.36, 2], units: ["N", "N"] }],
  });
  assert.deepEqual(failures(score()), []);
  assert.deepEqual(
    failures({ critical, criteria: [criterion(10), beyond] }).map((text) => text.replaceAll("\u00a0", " ")),
    ["The pulp is exposed.", "Light hand: 2.36 N (more than 2.00 N fails the whole attempt)."],
  );
});

test("the sentence names the score and the groups that lost most", () => {
  const sentence = (...criteria: readonly Criterion[]) => summarySentence(score({ criteria }));
  assert.equal(
    summarySentence(score()),
    "83.4 of 100. Most points were lost under “Margins” (−10), then under “Outline” (−4.5).",
  );
  assert.equal(
    sentence(group("outline", 0), criterion(1.5), criterion(0.6)),
    "83.4 of 100. Points were lost only under “Hand” (−2.1).",
  );
  assert.equal(sentence(group("outline", 0.01)), "83.4 of 100. No points were lost.");
  assert.match(summarySentence(score({ score: 0, critical_fail: true })), /^Not acceptable, so the score is 0/);
});

test("work that was stopped early and caries that was left are said before anything else", () => {
  const stopped = mistake({ kind: "not_done", place: "", size: 57, unit: "%" });
  const caries = mistake({ kind: "caries", place: "", size: 30, unit: "%" });
  assert.equal(stoppedEarly({ mistakes: [mistake({}), stopped] }), 43);
  assert.match(summarySentence(score({ score: 31, mistakes: [stopped] })), /^31\.0 of 100\. Only 43 % of the task was/);
  assert.equal(stoppedEarly({ mistakes: [caries] }), undefined, "ended, and left it");
  assert.equal(cariesLeft({ mistakes: [caries] }), 30);
  assert.match(summarySentence(score({ mistakes: [caries] })), /30 % of the caries was left/);
  assert.match(summarySentence(score({ mistakes: [mistake({}), caries] })), /“Margins”/, "not what cost most");
  assert.equal(stoppedEarly({ mistakes: [{ ...stopped, points: 0.2 }] }), undefined, "a rest that cost nothing");
  assert.equal(stoppedEarly(score()), undefined);
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
