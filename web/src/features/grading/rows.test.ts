import assert from "node:assert/strict";
import { test } from "node:test";
import type { Attempt, Score } from "../../api/types";
import { criteriaOf, type GradingRow, lostOn, named, sorted } from "./rows";

const row = (name: string, score: number | null, wall?: number, judged = true): GradingRow => ({
  attempt: { id: name, person: { id: name, display_name: name }, score, ticketed_ms: 0 } as unknown as Attempt,
  score:
    wall === undefined
      ? undefined
      : ({
          criteria: [
            {
              name: "wall_mesial_mm",
              title: "Mesial wall",
              value: 0,
              unit: "mm",
              points: 10 - wall,
              max_points: 10,
              reason: "",
              judged,
            },
          ],
        } as unknown as Score),
});
const names = (rows: readonly GradingRow[]) => rows.map(({ attempt }) => attempt.id);

test("who lost most on a criterion comes first, who has no score last, whichever way", () => {
  const rows = [row("A", 50, 2), row("B", 60, 9), row("C", null), row("D", 70, 5, false), row("E", 80, 2)];
  assert.deepEqual(names(sorted(rows, { by: "wall_mesial_mm", down: true })), ["B", "D", "A", "E", "C"]);
  assert.deepEqual(names(sorted(rows, { by: "wall_mesial_mm", down: false })), ["A", "E", "D", "B", "C"]);
  assert.deepEqual(names(sorted(rows, { by: "score", down: false })), ["A", "B", "D", "E", "C"]);
  assert.equal(lostOn(row("D", 70, 5, false), "wall_mesial_mm"), 5, "not made, and so not earned");
});

test("names are sorted as people count and found without accents and case", () => {
  const rows = [row("Student 10", 1), row("Student 9", 1), row("Zoë Ñandú", 1)];
  assert.deepEqual(names(sorted(rows, { by: "name", down: false })), ["Student 9", "Student 10", "Zoë Ñandú"]);
  assert.deepEqual(names(named(rows, " nandu ZOE")), ["Zoë Ñandú"]);
  assert.deepEqual(names(named(rows, "student 1")), ["Student 10"]);
  assert.equal(named(rows, "").length, 3);
});

test("each criterion is one column, also when attempts were judged by different rubrics", () => {
  const other = {
    ...row("B", 1, 1),
    score: { criteria: [{ name: "floor_mm", title: "Floor", points: 1, max_points: 1 }] } as unknown as Score,
  };
  assert.deepEqual(
    criteriaOf([row("A", 1, 1), other, row("C", 1)]).map(({ name }) => name),
    ["wall_mesial_mm", "floor_mm"],
  );
});
