import assert from "node:assert/strict";
import { test } from "node:test";
import type { Score } from "./types";
import { type Done, nextStep, progressOf } from "./progress";

const done = (atMs: number, points: Readonly<Record<string, number>>, unjudged: readonly string[] = []): Done => ({
  id: String(atMs),
  atMs,
  score: {
    criteria: Object.entries(points).map(([name, value]) => ({
      name,
      title: `Title ${name}`,
      value: 0,
      unit: "mm",
      points: value,
      max_points: unjudged.includes(name) ? 0 : 10,
      reason: `${name} at ${atMs}`,
      judged: !unjudged.includes(name),
    })),
  } as unknown as Score,
});

test("each criterion has its curve from the oldest attempt on, its best and its last", () => {
  const [wall, floor] = progressOf([
    done(3, { wall: 6, floor: 10 }),
    done(1, { wall: 2, floor: 5 }),
    done(2, { wall: 8, floor: 0 }, ["floor"]),
  ]);
  assert.deepEqual(wall?.shares, [0.2, 0.8, 0.6]);
  assert.deepEqual([wall?.best, wall?.last], [0.8, 0.6]);
  assert.deepEqual(floor?.shares, [0.5, 1], "where it was not judged it has no point");
});

test("what to do next is the largest loss that comes again, with what the newest attempt says", () => {
  const step = nextStep([
    done(1, { wall: 9, floor: 0 }),
    done(2, { wall: 5, floor: 10 }),
    done(3, { wall: 4, floor: 9.8 }),
    done(4, { wall: 6, floor: 1 }),
  ]);
  assert.deepEqual(step, { title: "Title wall", lost: 5, times: 3, of: 3, reason: "wall at 4" });
});

test("what the newest attempt got right is not what to do next", () => {
  const attempts = [done(1, { wall: 0, floor: 9 }), done(2, { wall: 2, floor: 9 }), done(3, { wall: 10, floor: 9 })];
  assert.equal(nextStep(attempts)?.title, "Title floor");
});

test("a loss that came once among several attempts is no habit; with one attempt it is all there is", () => {
  assert.equal(nextStep([done(1, { wall: 0 }), done(2, { wall: 10 })]), undefined);
  assert.equal(nextStep([done(1, { wall: 0 })])?.title, "Title wall");
  assert.equal(nextStep([]), undefined);
});
