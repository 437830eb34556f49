import assert from "node:assert/strict";
import { test } from "node:test";
import type { Grading } from "../../api/types";
import { attemptsOf, type GradedAttempt, lostOn, named, sorted } from "./rows";

const kWall = [{ name: "outline", title: "Outline" }] as const;
const attempt = (name: string, score: number | null, wall: number | null | undefined = undefined): GradedAttempt =>
  ({
    id: name,
    person: { id: name, display_name: name },
    score,
    ticketed_ms: 0,
    lost: wall === undefined ? null : [wall],
  }) as unknown as GradedAttempt;
const names = (attempts: readonly GradedAttempt[]) => attempts.map(({ id }) => id);

test("who lost most on a criterion comes first, who has no score last, whichever way", () => {
  const all = [attempt("A", 50, 2), attempt("B", 60, 9), attempt("C", null), attempt("D", 70, 5), attempt("E", 80, 2)];
  assert.deepEqual(names(sorted(all, { by: "outline", down: true }, kWall)), ["B", "D", "A", "E", "C"]);
  assert.deepEqual(names(sorted(all, { by: "outline", down: false }, kWall)), ["A", "E", "D", "B", "C"]);
  assert.deepEqual(names(sorted(all, { by: "score", down: false }, kWall)), ["A", "B", "D", "E", "C"]);
});

test("a criterion that the attempt's rubric does not have is nobody's to lose", () => {
  assert.equal(lostOn(attempt("A", 50, 0), 0), 0);
  assert.equal(lostOn(attempt("A", 50, null), 0), undefined);
  assert.equal(lostOn(attempt("A", 50, 2), 1), undefined);
  assert.equal(lostOn(attempt("A", null), 0), undefined);
});

test("names are sorted as people count and found without accents and case", () => {
  const all = [attempt("Student 10", 1), attempt("Student 9", 1), attempt("Zoë Ñandú", 1)];
  assert.deepEqual(names(sorted(all, { by: "name", down: false }, kWall)), ["Student 9", "Student 10", "Zoë Ñandú"]);
  assert.deepEqual(names(sorted(all, { by: "name", down: true }, kWall)), ["Zoë Ñandú", "Student 10", "Student 9"]);
  assert.deepEqual(names(named(all, " nandu ZOE")), ["Zoë Ñandú"]);
  assert.deepEqual(names(named(all, "student 1")), ["Student 10"]);
  assert.equal(named(all, "").length, 3);
});

test("each attempt gets the exercise that the answer names once", () => {
  const grading = {
    exercises: [{ id: "x", title: "Exercise", graded: true }],
    attempts: [{ id: "a", exercise: 0 }],
  } as unknown as Grading;
  assert.equal(attemptsOf(grading)[0]?.exercise.title, "Exercise");
});
