import assert from "node:assert/strict";
import { test } from "node:test";
import { isAmong, placeAmong } from "./envelope_place";

test("a value on the edge is among the dentists', and one beyond names its side", () => {
  const dentists = { least: 1, most: 2 };
  assert.equal(placeAmong({ value: 1, ...dentists }), "among them");
  assert.equal(placeAmong({ value: 2, ...dentists }), "among them");
  assert.equal(placeAmong({ value: 0.9, ...dentists }), "below all");
  assert.equal(placeAmong({ value: 2.1, ...dentists }), "above all");
  assert.deepEqual(
    [0.9, 1, 2, 2.1].map((value) => isAmong({ value, ...dentists })),
    [false, true, true, false],
  );
});
