import assert from "node:assert/strict";
import { test } from "node:test";
import { freshBur } from "./other_burs";

test("a bur that is added has a shape that no other has", () => {
  const first = { shape: "cylinder", radius_um: 500, length_um: 4000 };
  const round = freshBur([first]);
  assert.deepEqual(round, { shape: "sphere", radius_um: 500, length_um: 0 });
  const next = freshBur([first, round, { shape: "sphere", radius_um: 600, length_um: 0 }]);
  assert.deepEqual(next, { shape: "sphere", radius_um: 700, length_um: 0 });
});
