import assert from "node:assert/strict";
import { test } from "node:test";
import type { AssignmentInsight } from "../../api/types";
import { csvText } from "../../base/csv";
import { commonestText, insightTable, outlierText } from "./insight";

const tenths: AssignmentInsight["summary"]["score_tenths"] = [0, 0, 0, 0, 0, 0, 0, 0, 0, 0];
const criterion = { name: "wall_mesial_mm", title: "Mesial wall", unit: "mm", max_points: 20, judged: 3, half_lost: 2, mean_points: 8, earned_tenths: tenths, values: null };
const insight: AssignmentInsight = {
  assignment_id: "a", counting: "best", gates: [], outliers: [], staff: [], left_out: 0, unread: 0, commonest: "wall_mesial_mm", criteria: [criterion],
  summary: { students: 2, not_started: 1, waiting: 0, scored: 1, failed: 0, scores: null, times_s: null, score_tenths: tenths },
  students: [
    { person: { id: "1", login: "one", display_name: "=cmd|' /C calc'!A0" }, state: "scored", attempts: 2, score: 71.4285, released: false, time_s: 61.04, failed: false, attempt_id: "x", points: [8.26] },
    { person: { id: "2", login: "@two", display_name: "Two" }, state: "not_started", attempts: 0, score: null, released: false, time_s: 0, failed: false, attempt_id: null, points: [null] },
  ],
};

test("the commonest error is a sentence, and so is that there is none", () => {
  assert.equal(commonestText(insight), "Most went wrong on Mesial wall: 2 of 3 students lost half of its points or more.");
  assert.equal(commonestText({ ...insight, commonest: null }), "On no criterion did anybody lose half of the points.");
  assert.equal(commonestText({ ...insight, commonest: null, summary: { ...insight.summary, scored: 0 } }), "Nothing is scored yet.");
});

test("what stands out is told in its unit, beside the class", () => {
  assert.equal(outlierText({ person_id: "1", what: "time_s", value: 725, median: 240, z: 5 }, []), "Time 12\u00a0min\u00a005\u00a0s, the class 4\u00a0min\u00a000\u00a0s");
  assert.equal(outlierText({ person_id: "1", what: "wall_mesial_mm", value: 0.9, median: 0.12, z: 5 }, [criterion]), "Mesial wall 0.90\u00a0mm too deep, the class 0.12\u00a0mm too deep");
  assert.equal(outlierText({ person_id: "1", what: "score", value: 12, median: 80, z: -5 }, []), "Score 12.0, the class 80.0");
});

test("the file has a row for each student and no cell that a spreadsheet computes", () => {
  const { header, rows } = insightTable(insight);
  const lines = csvText(header, rows).split("\r\n");
  assert.equal(lines[0], "\uFEFFlogin,display_name,state,attempts,score,released,failed_critically,time_s,Mesial wall (of 20)");
  assert.equal(lines[1], "one,'=cmd|' /C calc'!A0,scored,2,71.4,no,no,61,8.3");
  assert.equal(lines[2], "'@two,Two,not_started,0,,no,no,0,");
});
