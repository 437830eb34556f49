import assert from "node:assert/strict";
import { test } from "node:test";
import type { RosterOutcome } from "../../api/types";
import { asksAboutOthers, detailText, leftOutText, readings } from "./roster";

const person: RosterOutcome["people"][number] = {
  row: 2,
  login: "sam",
  display_name: "Sam",
  role: "student",
  cohort: "Section 2",
  others: [],
  change: "update",
  renames: false,
  joins: true,
  note: "",
};
const outcome: RosterOutcome = {
  done: false,
  reading: "utf-8",
  created: 0,
  updated: 1,
  unchanged: 0,
  new_cohorts: [],
  ignored_columns: [],
  left_out: [],
  problem_count: 0,
  problems: [],
  people: [person],
  passwords: [],
};

test("a student of another cohort is asked about, and the row says what becomes of them", () => {
  const moving = { ...person, others: ["Section 1", "Elective"] };
  assert.equal(asksAboutOthers(outcome), false);
  assert.equal(asksAboutOthers({ ...outcome, people: [person, moving] }), true);
  assert.equal(detailText(person, "leave"), "joins the cohort");
  assert.equal(detailText(moving, ""), "joins the cohort; is also in Section 1, Elective");
  assert.equal(detailText(moving, "leave"), "joins the cohort; leaves Section 1, Elective");
  assert.equal(detailText({ ...person, joins: false }, ""), "–");
});

test("rows that are no person are named", () => {
  assert.equal(
    leftOutText({ ...outcome, left_out: [{ row: 9, text: "Total: 7" }] }),
    "Not imported, because it is no person: row 9 (Total: 7).",
  );
});

test("every reading has a name of its own", () => {
  assert.equal(new Set(readings().map(({ title }) => title)).size, 7);
});
