import assert from "node:assert/strict";
import { test } from "node:test";
import type { Mistake, Score } from "./types";
import { type Done, nextStep, progressOf } from "./progress";

type Lost = Readonly<Record<string, number>>;

const done = (atMs: number, lost: Lost, hand: Lost = {}, unjudged: readonly string[] = []): Done => ({
  id: String(atMs),
  atMs,
  score: {
    mistakes: Object.entries(lost).map(
      ([where, points]) =>
        ({
          kind: where === "floor" ? "deep" : "over_extended",
          place: where.replace(/ .*/, ""),
          size: 0.1 * atMs,
          unit: "mm",
          points,
        }) as Mistake,
    ),
    criteria: Object.entries(hand).map(([name, points]) => ({
      name,
      group: "hand",
      title: `Title ${name}`,
      lost: points,
      most: 10,
      judged: !unjudged.includes(name),
      reason: `${name} at ${atMs}`,
    })),
  } as unknown as Score,
});
const plain = (text = "") => text.replaceAll("\u00a0", " ");

test("each criterion has its curve from the oldest attempt on, its least and its last loss", () => {
  const [time, force] = progressOf([
    done(3, {}, { time: 4, force: 0 }),
    done(1, {}, { time: 12, force: 5 }),
    done(2, {}, { time: 2, force: 9 }, ["force"]),
  ]);
  assert.deepEqual(time?.lost, [12, 2, 4]);
  assert.deepEqual([time?.least, time?.last, time?.most], [2, 4, 12]);
  assert.deepEqual(force?.lost, [5, 0], "where it was not judged it has no point");
  assert.equal(force?.most, 10);
});

test("what to do next is the mistake that cost most and came again, with its remedy", () => {
  const step = nextStep([
    done(1, { floor: 20 }),
    done(2, { wall_distal: 5, floor: 0.1 }),
    done(3, { wall_distal: 6, wall_mesial: 30 }),
    done(4, { wall_distal: 4, floor: 9 }),
  ]);
  assert.equal(plain(step?.title), "Distal wall: over-extended by 0.40 mm", "as the newest attempt has it");
  assert.deepEqual([step?.lost, step?.times, step?.of], [5, 3, 3]);
  assert.match(step?.remedy ?? "", /^Stop short of the outline/);
});

test("two mistakes of a kind at one place are one, and count once", () => {
  const step = nextStep([done(1, { "wall_distal a": 2, "wall_distal b": 1 }), done(2, { wall_distal: 5 })]);
  assert.deepEqual([step?.lost, step?.times], [4, 2]);
});

test("a figure of the hand may cost more than any mistake", () => {
  const step = nextStep([done(1, { floor: 2 }, { time: 6 }), done(2, { floor: 2 }, { time: 4 })]);
  assert.deepEqual(step, { title: "Title time", lost: 5, times: 2, of: 2, remedy: "time at 2" });
});

test("what the newest attempt got right is not what to do next", () => {
  const attempts = [
    done(1, { wall_distal: 10, floor: 1 }),
    done(2, { wall_distal: 8, floor: 1 }),
    done(3, { floor: 1 }),
  ];
  assert.equal(plain(nextStep(attempts)?.title), "Floor: 0.30 mm too deep");
});

test("a mistake that came once among several attempts is no habit; with one attempt it is all there is", () => {
  assert.equal(nextStep([done(1, {}), done(2, { floor: 10 })]), undefined);
  assert.equal(nextStep([done(1, { floor: 10 })])?.lost, 10);
  assert.equal(nextStep([done(1, { floor: 0.4 })]), undefined, "too little to work on");
  assert.equal(nextStep([]), undefined);
});
