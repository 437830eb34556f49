import assert from "node:assert/strict";
import { test } from "node:test";
import type { Series } from "../../api/types";
import { matchPaths, pathMatch, thinned } from "./path_sync";

type Point = readonly [number, number, number];
// A step each second.
const series = (anchor_mm: readonly Point[]) =>
  ({ rate_hz: 1000, step_ticks: 1000, t_s: anchor_mm.map((_, i) => i), anchor_mm }) as unknown as Series;
// Round a circle and down: no place comes twice.
const along = (turns: number): Point => [3 * Math.cos(turns), 3 * Math.sin(turns), -0.2 * turns];
const way = (steps: number, stepTurns: number) => Array.from({ length: steps }, (_, i) => along(i * stepTurns));
const at = (own: Series, other: Series, times: readonly number[]) => times.map(matchPaths(own, other));

test("on equal paths the time is the same", () => {
  const own = series(way(40, 0.1));
  assert.deepEqual(at(own, series(way(40, 0.1)), [0, 0.25, 7, 38.5, 39]), [0, 0.25, 7, 38.5, 39]);
  assert.deepEqual(at(own, own, [40, 50]), [40, 40], "and the end is the end");
});

test("a path at half speed needs twice the time, and one at double speed half of it", () => {
  const [fast, slow] = [series(way(41, 0.1)), series(way(81, 0.05))];
  for (const timeS of [0, 1, 7.5, 20, 39]) {
    assert.ok(Math.abs(matchPaths(fast, slow)(timeS) - 2 * timeS) < 1e-9, `${timeS} s`);
    assert.ok(Math.abs(matchPaths(slow, fast)(2 * timeS) - timeS) < 1e-9, `${2 * timeS} s back`);
  }
  assert.equal(matchPaths(slow, fast)(15), 7.5, "between two steps of the fast one");
});

test("a pause of one is skipped", () => {
  const going = way(20, 0.1);
  const paused = series([...going.slice(0, 10), ...Array<Point>(30).fill(going[9]!), ...going.slice(10)]);
  assert.deepEqual(at(series(going), paused, [8, 9, 10, 15]), [8, 9, 40, 45], "the other’s");
  assert.deepEqual(
    at(paused, series(going), [8, 9, 20, 39, 40, 45]),
    [8, 9, 9, 9, 10, 15],
    "one’s own: meanwhile the other stands still",
  );
});

test("a lifted bur keeps its place, and never goes back", () => {
  const going = way(60, 0.1);
  const [x, y, z] = going[29]!;
  const lifts = series([
    ...going.slice(0, 30),
    ...Array.from({ length: 20 }, (_, i): Point => [x, y, z + 9 - Math.abs(i - 10) / 2]),
    ...going.slice(30),
  ]);
  const match = matchPaths(lifts, series(going));
  assert.deepEqual([10, 29, 50, 60, 79].map(match), [10, 29, 30, 40, 59]);
  let before = -1;
  for (let timeS = 0; timeS < 80; timeS += 0.1) {
    assert.ok(match(timeS) >= before, `${timeS} s`);
    if (timeS > 29 && timeS < 50) assert.ok(match(timeS) <= 30);
    before = match(timeS);
  }
});

test("series of no step and of one", () => {
  const [none, one, many] = [series([]), series([along(0)]), series(way(5, 0.1))];
  assert.deepEqual(at(none, many, [0, 2, 9]), [0, 2, 5], "nothing to go by: the same time");
  assert.deepEqual(at(many, none, [0, 2]), [0, 1]);
  assert.deepEqual(at(one, many, [0, 1]), [0, 5]);
  assert.deepEqual(at(many, one, [0, 4, 5]), [0, 0, 1]);
  assert.deepEqual(at(one, one, [0, 0.5, 1]), [0, 0.5, 1]);
});

test("long ones are thinned, the last step is kept, and two are worked out once", () => {
  assert.deepEqual(thinned(5, 3), [0, 2, 4]);
  assert.deepEqual(thinned(6, 3), [0, 3, 5]);
  assert.deepEqual([thinned(0), thinned(1), thinned(2)], [[], [0], [0, 1]]);
  assert.equal(thinned(1000).length, 1000);
  for (const steps of [1001, 2000, 25_000]) {
    assert.ok(thinned(steps).length <= 1000, `${thinned(steps).length} of ${steps}`);
    assert.equal(thinned(steps).at(-1), steps - 1);
  }
  const [own, other] = [series(way(5000, 0.01)), series(way(2500, 0.02))];
  assert.ok(Math.abs(matchPaths(own, other)(3000) - 1500) < 5, "by the nearest of what is left");
  assert.equal(pathMatch(own, other), pathMatch(own, other));
  assert.notEqual(pathMatch(own, other), pathMatch(other, own));
});
