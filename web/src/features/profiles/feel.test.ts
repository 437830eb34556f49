import assert from "node:assert/strict";
import { test } from "node:test";
import { closedFormError, couplingOf, kShares, stiffestGrip } from "./feel";

test("the error is kh/(kh + K) where tissue is hard and the hand is soft", () => {
  assert.ok(Math.abs(closedFormError(1, 10, 1000) - 1 / 11) < 1e-3);
});

test("the stiffest grip is where the error is the share", () => {
  for (const share of kShares) {
    assert.ok(Math.abs(closedFormError(stiffestGrip(10, 8.7, share), 10, 8.7) - share) < 1e-6);
  }
});

test("not even a loose grip, and any grip", () => {
  assert.equal(stiffestGrip(1, 8.7, 0.07), 0);
  assert.equal(stiffestGrip(1000, 0.3, 0.19), Number.POSITIVE_INFINITY);
});

test("every device has motors except the pointer", () => {
  const numbers = [{ name: "coupling", value: 1250, unit: "mN/mm", source: "measured" }] as const;
  assert.equal(couplingOf({ name: "omega7", numbers }), 1.25);
  assert.equal(couplingOf({ name: "pointer", numbers }), undefined);
});
