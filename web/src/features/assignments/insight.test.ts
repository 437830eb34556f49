import assert from "node:assert/strict";
import { test } from "node:test";
import type { AssignmentInsight } from "../../api/types";
import { mistakeText } from "../../api/worded";
import { csvText } from "../../base/csv";
import { commonestText, insightTable, outliersOf, outlierText } from "./insight";

const tenths: AssignmentInsight["summary"]["score_tenths"] = [0, 0, 0, 0, 0, 0, 0, 0, 0, 0];
const criterion: AssignmentInsight["criteria"][number] = {
  name: "outline",
  group: "outline",
  title: "Outline",
  unit: "count",
  judged: 3,
  to_change: 2,
  mean_lost: 8,
  lost: null,
  values: null,
};
const force: typeof criterion = {
  ...criterion,
  name: "force_sent_p95_n",
  group: "hand",
  title: "Light hand",
  unit: "N",
};
const mistake: AssignmentInsight["mistakes"][number] = {
  kind: "over_extended",
  place: "wall_mesial",
  group: "outline",
  students: 2,
  points: 21.5,
  size: 0.42,
  unit: "mm",
  at_mm: [1.5, 0, 3],
};
const insight: AssignmentInsight = {
  assignment_id: "a",
  counting: "best",
  outliers: [],
  staff: [],
  left_out: 0,
  unread: 0,
  commonest: 1,
  criteria: [criterion, force],
  mistakes: [{ ...mistake, kind: "deep", place: "floor", students: 1 }, mistake],
  summary: {
    students: 2,
    not_started: 1,
    waiting: 0,
    scored: 1,
    failed: 0,
    scores: null,
    times_s: null,
    score_tenths: tenths,
  },
  students: [
    {
      person: { id: "1", login: "one", display_name: "=cmd|' /C calc'!A0" },
      state: "scored",
      attempts: 2,
      score: 71.4285,
      released: false,
      time_s: 61.04,
      failed: false,
      attempt_id: "x",
      lost: [8.26, 0],
    },
    {
      person: { id: "2", login: "@two", display_name: "Two" },
      state: "not_started",
      attempts: 0,
      score: null,
      released: false,
      time_s: 0,
      failed: false,
      attempt_id: null,
      lost: [null, null],
    },
  ],
};

test("the most common mistake is a sentence, and so is that there is none", () => {
  assert.equal(
    commonestText({ ...insight, summary: { ...insight.summary, scored: 3 } }),
    `Most common mistake: “${mistakeText(mistake)}”, made by 2 of 3 students.`,
  );
  assert.equal(commonestText({ ...insight, commonest: null }), "No mistake cost anybody half a point.");
  assert.equal(
    commonestText({ ...insight, commonest: null, summary: { ...insight.summary, scored: 0 } }),
    "Nothing is scored yet.",
  );
});

test("an outlier is shown in its unit, beside the class", () => {
  assert.equal(
    outlierText({ person_id: "1", what: "time_all_attempts_s", value: 725, median: 240, z: 5 }, insight),
    "Time in all attempts 12\u00a0min\u00a005\u00a0s; class 4\u00a0min\u00a000\u00a0s",
  );
  assert.equal(
    outlierText({ person_id: "1", what: "force_sent_p95_n", value: 0.9, median: 0.12, z: 5 }, insight),
    "Light hand 0.90\u00a0N; class 0.12\u00a0N",
  );
  assert.equal(
    outlierText({ person_id: "1", what: "score", value: 12, median: 80, z: -5 }, insight),
    "Score 12.0; class 80.0",
  );
});

test("the file has a row for each student and no cell that a spreadsheet computes", () => {
  const { header, rows } = insightTable(insight);
  const lines = csvText(header, rows).split("\r\n");
  assert.equal(
    lines[0],
    "\uFEFFlogin,display_name,state,attempts,score,released,failed_critically,time_s_all_attempts,Outline (points lost),Light hand (points lost)",
  );
  assert.equal(lines[1], "one,'=cmd|' /C calc'!A0,scored,2,71.4,no,no,61,8.3,0");
  assert.equal(lines[2], "'@two,Two,not_started,0,,no,no,0,,");
});

test("the time of all attempts and that of the counted attempt have different names, and equal times appear once", () => {
  const spread = (median: number) => ({ count: 8, least: 60, lower: 84, median, upper: 110, most: 200 });
  const time: typeof criterion = { ...criterion, name: "time_s", title: "Time", unit: "s", values: spread(95) };
  const outliers = (
    [
      ["1", 189, 97, "time_all_attempts_s"],
      ["1", 160, 95, "time_s"],
      ["2", 200, 97, "time_all_attempts_s"],
      ["2", 200, 95, "time_s"],
      ["3", 160, 95, "time_s"],
    ] as const
  ).map(([person_id, value, median, what]) => ({ person_id, what, value, median, z: 5 }));
  const [first, second] = insight.students;
  const told = {
    ...insight,
    criteria: [criterion, time],
    outliers,
    summary: { ...insight.summary, times_s: spread(97) },
    students: [first!, { ...second!, attempts: 1 }],
  };
  assert.deepEqual(
    outliersOf(told).map((outlier) => outlierText(outlier, told).replaceAll("\u00a0", " ")),
    [
      "Time in all attempts 3 min 09 s; class 1 min 37 s",
      "Time 2 min 40 s; class 1 min 35 s",
      "Time in all attempts 3 min 20 s; class 1 min 37 s",
      "Time 2 min 40 s; class 1 min 35 s",
    ],
  );
});
