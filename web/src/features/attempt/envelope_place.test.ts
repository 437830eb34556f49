import assert from "node:assert/strict";
import { test } from "node:test";
import { isAmong, placeAmong } from "./envelope_place";

test("a value on the edge is among the dentists', and one beyond names its side", () => {
  const dentists = { least: 1, most: 2, unit: "mm" };
  assert.equal(placeAmong({ value: 1, ...dentists }), "among them");
  assert.equal(placeAmong({ value: 2, ...dentists }), "among them");
  assert.equal(placeAmong({ value: 0.9, ...dentists }), "below all");
  assert.equal(placeAmong({ value: 2.1, ...dentists }), "above all");
  assert.deepEqual(
    [0.9, 1, 2, 2.1].map((value) => isAmong({ value, ...dentists })),
    [false, true, true, false],
  );
});

test("a value that shows as an edge is among them", () => {
  const dentists = { least: 0, most: 0, unit: "deg" };
  assert.equal(placeAmong({ value: 0.004, ...dentists }), "among them");
  assert.equal(placeAmong({ value: -0.004, ...dentists }), "among them");
  assert.equal(placeAmong({ value: 0.2, ...dentists }), "above all");
});
