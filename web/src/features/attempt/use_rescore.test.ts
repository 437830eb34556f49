import assert from "node:assert/strict";
import { test } from "node:test";
import { isOver } from "./use_rescore";

const asked = { newest: 2, problem: "", begun: false };
const scored = { state: "scored", problem: "" } as const;

test("a run that waits in the queue is not over, although the attempt has its earlier score", () => {
  assert.equal(isOver(asked, 2, scored), false);
});

test("a run is over with its result, also where nobody saw it under way", () => {
  assert.equal(isOver(asked, 3, scored), true);
});

test("a run that failed is over", () => {
  assert.equal(isOver(asked, 2, { ...scored, problem: "the recording cannot be read" }), true);
  assert.equal(isOver({ ...asked, problem: "no", begun: true }, 2, { ...scored, problem: "no" }), true);
  assert.equal(isOver({ ...asked, newest: 0 }, 0, { state: "failed", problem: "no" }), true);
});

test("a run under way is not over", () => {
  assert.equal(isOver({ ...asked, begun: true }, 2, { ...scored, state: "scoring" }), false);
});
