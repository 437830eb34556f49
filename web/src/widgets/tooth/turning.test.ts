import assert from "node:assert/strict";
import { test } from "node:test";
import { pinched } from "./turning";

test("two fingers that go apart come nearer, and their middle carries the picture", () => {
  const from = [
    [0, 0],
    [100, 0],
  ] as const;
  assert.deepEqual(
    pinched(from, [
      [-50, 0],
      [150, 0],
    ]),
    { moved: [0, 0], factor: 0.5 },
  );
  assert.deepEqual(
    pinched(from, [
      [20, 30],
      [120, 30],
    ]),
    { moved: [20, 30], factor: 1 },
  );
});

test("fingers at one place do not bring the tooth into the eye", () => {
  const one = [
    [5, 5],
    [5, 5],
  ] as const;
  assert.equal(pinched(one, one).factor, 1);
});
