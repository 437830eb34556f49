import assert from "node:assert/strict";
import { test } from "node:test";
import { mesialX } from "./tooth_number";

test("mesial is at +x in quadrants 1, 3, 5 and 7, at -x in the others, and at +x of a block", () => {
  assert.deepEqual([11, 36, 55, 75].map(mesialX), [1, 1, 1, 1]);
  assert.deepEqual([21, 46, 65, 85].map(mesialX), [-1, -1, -1, -1]);
  assert.equal(mesialX(null), 1);
});
