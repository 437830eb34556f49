import assert from "node:assert/strict";
import { test } from "node:test";
import { dotsOf, type NumberedMistake } from "./mistake_dots";

const at = (number: number, x: number, y: number, students = 3): NumberedMistake => ({
  kind: "groove",
  place: "floor",
  group: "internal_form",
  students,
  points: 5,
  size: 0.3,
  unit: "mm",
  at_mm: [x, y, 2],
  number,
});

test("a dot is where the mistake is, and larger where more students made it", () => {
  const [one, all] = dotsOf([at(1, -2, 1, 1), at(2, 2, 0.5, 10)], 10);
  assert.deepEqual([one?.x, one?.y, all?.x, all?.y], [-2, 1, 2, 0.5]);
  assert.ok(all!.radius > one!.radius);
});

test("dots at one place part, and none covers another", () => {
  const dots = dotsOf([at(1, 0, 0), at(2, 0, 0), at(3, 0, 0), at(4, 0.1, 0), at(5, 3, 0)], 3);
  dots.forEach((a, i) => {
    for (const b of dots.slice(i + 1))
      assert.ok(Math.hypot(a.x - b.x, a.y - b.y) > 0.98 * (a.radius + b.radius), `${a.number} ${b.number}`);
  });
  assert.deepEqual([dots[4]?.x, dots[4]?.y], [3, 0]);
});

test("a mistake without a place has no dot", () => {
  assert.deepEqual(
    dotsOf([at(1, Number.NaN, 0), at(2, 1, 1)], 3).map(({ number }) => number),
    [2],
  );
});
