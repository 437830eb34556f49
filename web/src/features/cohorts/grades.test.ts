import assert from "node:assert/strict";
import { test } from "node:test";
import type { Assignment, Attempt, CohortMember } from "../../api/types";
import { attemptsTable, gradeRows, gradesTable } from "./grades";

const member = (id: string, role = "student") => ({ id, login: `login.${id}`, display_name: `Name ${id}`, role }) as unknown as CohortMember;
const assignment = (id: string) => ({ id, exercise: { title: `Exercise ${id}` } }) as unknown as Assignment;
const attempt = (person: string, under: string, score: number | null, flags: string[] = []) => ({
  id: `${person}-${under}-${score}`, person: { id: person, display_name: `Name ${person}` }, exercise: { title: "E", version: 2 }, station: { name: "S" },
  assignment_id: under, score, computed_score: score, critical_fail: false, released: true, exam: false, flags, state: "scored", ticketed_ms: 1000, sealed_ms: 0,
}) as unknown as Attempt;

test("the best attempt under an assignment counts; excused and unscored ones do not", () => {
  const rows = gradeRows([member("b"), member("a"), member("i", "instructor")], [assignment("x"), assignment("y")],
    [attempt("a", "x", 70), attempt("a", "x", 85), attempt("a", "x", 99, ["excused"]), attempt("a", "y", null), attempt("b", "z", 50)]);
  assert.deepEqual(rows.map((row) => row.member.id), ["a", "b"]);
  assert.equal(rows[0]?.grades[0]?.best?.score, 85);
  assert.equal(rows[0]?.grades[0]?.attempts, 2);
  assert.equal(rows[0]?.grades[1]?.best, undefined);
  assert.equal(rows[0]?.grades[1]?.attempts, 1);
  assert.deepEqual(rows[1]?.grades.map((grade) => grade.attempts), [0, 0]);
});

test("the exported grades have a row for each student and a column for each assignment, empty where nothing is scored", () => {
  const assignments = [assignment("x"), assignment("y")];
  const table = gradesTable(gradeRows([member("a")], assignments, [attempt("a", "x", 85)]), assignments);
  assert.deepEqual(table.header, ["person", "login", "display_name", "Exercise x", "Exercise y", "assignments_done"]);
  assert.deepEqual(table.rows, [["a", "login.a", "Name a", 85, null, 1]]);
});

test("the exported attempts have as many cells as the header names", () => {
  const table = attemptsTable([attempt("a", "x", 85, ["late", "over_time"])]);
  assert.equal(table.rows[0]?.length, table.header.length);
  assert.ok(table.rows[0]?.includes("late over_time"));
});
