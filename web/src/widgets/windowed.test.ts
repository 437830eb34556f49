import assert from "node:assert/strict";
import { test } from "node:test";
import { around } from "./windowed";

test("rows around the window are in the page, and the one with the focus wherever it is", () => {
  assert.deepEqual(around(0, 2, 10, undefined), [0, 1, 2, 3, 4, 5, 6, 7, 8, 9]);
  const middle = around(100, 120, 5000, undefined);
  assert.equal(middle[0], 88);
  assert.equal(middle.at(-1), 132);
  assert.deepEqual(around(100, 120, 5000, 3).slice(0, 2), [3, 88]);
  assert.deepEqual(around(100, 120, 5000, 4000).at(-1), 4000);
  assert.deepEqual(around(100, 120, 5000, 110), middle);
  assert.deepEqual(around(100, 120, 5000, 9000), middle, "it is not there any more");
});
