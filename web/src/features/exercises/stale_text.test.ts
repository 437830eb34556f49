import assert from "node:assert/strict";
import { test } from "node:test";
import { mendedText, staleLengths } from "./stale_text";

const exercise = (depthUm: number, halfUm: number, instructions: string) => ({
  instructions,
  target: { depth_um: depthUm, half_size_um: [halfUm, 1200], container_um: 500 },
});
const kText = "Prepare a box 4 mm long and 2.0 mm deep. Keep 12.0 mm and 0.5 mm.";

test("a copy whose depth was changed still says the old one, which is found and mended", () => {
  const read = exercise(2000, 2000, kText);
  const stale = staleLengths(read, exercise(1500, 2250, kText));
  assert.deepEqual(stale, [
    { said: "4 mm", now: "4.5 mm" },
    { said: "2.0 mm", now: "1.5 mm" },
  ]);
  assert.equal(mendedText(kText, stale), "Prepare a box 4.5 mm long and 1.5 mm deep. Keep 12.0 mm and 0.5 mm.");
});

test("a decimal comma stays one", () => {
  const text = "2,0 mm tief";
  assert.deepEqual(staleLengths(exercise(2000, 1, text), exercise(1250, 1, text)), [
    { said: "2,0 mm", now: "1,25 mm" },
  ]);
});

test("a text that was changed too, or a target that was not, has nothing stale", () => {
  assert.deepEqual(staleLengths(exercise(2000, 1, kText), exercise(1500, 1, "1.5 mm deep")), []);
  assert.deepEqual(staleLengths(exercise(2000, 1, kText), exercise(2000, 1, kText)), []);
});
