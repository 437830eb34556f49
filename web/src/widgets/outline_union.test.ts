import assert from "node:assert/strict";
import { test } from "node:test";

import { isInside, outside, type Point2 } from "./outline_union";

const box = (x0: number, y0: number, x1: number, y1: number): Point2[] => [
  [x0, y0],
  [x1, y0],
  [x1, y1],
  [x0, y1],
];
const lengthOf = (lines: readonly (readonly Point2[])[]): number =>
  lines
    .flatMap((line) => line.slice(1).map((to, i) => Math.hypot(to[0] - line[i]![0], to[1] - line[i]![1])))
    .reduce((sum, length) => sum + length, 0);

test("a ring by itself is one closed line", () => {
  const lines = outside(box(0, 0, 2000, 1000), []);
  assert.equal(lines.length, 1);
  assert.deepEqual(lines[0]!.at(0), lines[0]!.at(-1));
  assert.equal(lengthOf(lines), 6000);
});

test("two bars that cross leave the border of a cross", () => {
  const [lying, standing] = [box(-3000, -750, 3000, 750), box(-750, -3000, 750, 3000)];
  const lines = [...outside(lying, [standing]), ...outside(standing, [lying])];
  // Four ends of 1500, eight sides of 2250.
  assert.equal(lengthOf(lines), 4 * 1500 + 8 * 2250);
  for (const line of lines) for (const point of line) assert.ok(!isInside(point, lying) && !isInside(point, standing));
});

test("a ring within another one vanishes; along its border it stays", () => {
  assert.deepEqual(outside(box(100, 100, 900, 900), [box(0, 0, 1000, 1000)]), []);
  assert.equal(lengthOf(outside(box(0, 100, 900, 900), [box(0, 0, 1000, 1000)])), 800);
});

test("two rings that cut a side part the border in two", () => {
  const lines = outside(box(0, 0, 9000, 1000), [box(2000, -500, 3000, 500), box(5000, -500, 6000, 500)]);
  assert.equal(lengthOf(lines), 20000 - 2000);
  assert.equal(lines.length, 2);
});
