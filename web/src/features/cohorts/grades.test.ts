import assert from "node:assert/strict";
import { test } from "node:test";
import type { Attempt, CohortGrades } from "../../api/types";
import { attemptsTable, gradesTable } from "./grades";

const attempt = (person: string, under: string, score: number | null, flags: string[] = []) =>
  ({
    id: `${person}-${under}-${score}`,
    person: { id: person, display_name: `Name ${person}` },
    exercise: { title: "E", version: 2 },
    station: { name: "S" },
    assignment_id: under,
    score,
    computed_score: score,
    critical_fail: false,
    released: true,
    exam: false,
    flags,
    state: "scored",
    ticketed_ms: 1000,
    sealed_ms: 0,
  }) as unknown as Attempt;

const summary = { students: 1, graded: 1, mean: 81.666, median: 85, lowest: 70, highest: 90 };
const grades: CohortGrades = {
  assignments: [
    {
      id: "x",
      exercise: { name: "x", title: "Exercise x", version: 2 },
      everybody: false,
      exam: false,
      counting: "mean",
      summary,
    },
    {
      id: "y",
      exercise: { name: "y", title: "", version: 1 },
      everybody: true,
      exam: true,
      counting: "best",
      summary: { ...summary, graded: 0 },
    },
  ],
  students: [
    {
      person: { id: "a", login: "login.a", display_name: "Name a" },
      grades: [
        { attempts: 4, counted: 3, score: 81.666, attempt_id: null, released: true },
        { attempts: 1, counted: 0, score: null, attempt_id: null, released: false },
      ],
    },
  ],
};

test("the exported grades have the result of each assignment, how many attempts count, and whether it is released", () => {
  const table = gradesTable(grades);
  assert.deepEqual(table.header, [
    "person",
    "login",
    "display_name",
    "Exercise x",
    "y",
    "assignments_done",
    "Exercise x (mean of attempts)",
    "Exercise x (released)",
    "y (best of attempts)",
    "y (released)",
  ]);
  assert.deepEqual(table.rows, [["a", "login.a", "Name a", 81.7, null, 1, 3, true, 0, false]]);
});

test("the exported attempts have as many cells as the header names", () => {
  const table = attemptsTable([attempt("a", "x", 85, ["late", "over_time"])]);
  assert.equal(table.rows[0]?.length, table.header.length);
  assert.ok(table.rows[0]?.includes("late over_time"));
});
