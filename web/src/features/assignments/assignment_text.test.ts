import assert from "node:assert/strict";
import { test } from "node:test";
import { dueProblem, dueText, endedTerms, leftText, phaseOf } from "./assignment_text";

const day = 86_400_000;
const terms = (opens: number, due: number, late = false) => ({ opens_ms: opens, due_ms: due, late_allowed: late });

test("an assignment is before, open, late or closed", () => {
  assert.equal(phaseOf(terms(10 * day, 20 * day), 5 * day), "before");
  assert.equal(phaseOf(terms(10 * day, 20 * day), 15 * day), "open");
  assert.equal(phaseOf(terms(10 * day, 20 * day), 21 * day), "closed");
  assert.equal(phaseOf(terms(10 * day, 20 * day, true), 21 * day), "late");
  assert.equal(phaseOf(terms(0, 0), 15 * day), "open");
});

test("a due time that has passed, or comes before the opening, is said when it is set", () => {
  assert.match(dueProblem(terms(0, 5 * day), 6 * day) ?? "", /has passed, so nobody could start/);
  assert.match(dueProblem(terms(0, 5 * day, true), 6 * day) ?? "", /every attempt would be late/);
  assert.match(dueProblem(terms(5 * day, 4 * day), day) ?? "", /after the assignment opens/);
  assert.equal(dueProblem(terms(0, 5 * day), 4 * day), undefined);
  assert.equal(dueProblem(terms(0, 0), 4 * day), undefined);
});

test("due dates and remaining attempts are shown in words", () => {
  assert.match(dueText({ due_ms: 20 * day }, 17 * day), /in 3 days/);
  assert.equal(dueText({ due_ms: 0 }, day), "No due date");
  assert.equal(leftText({ attempts_left: 0 }), "None left");
  assert.equal(leftText({ attempts_left: 1 }), "1 attempt left");
  assert.equal(leftText({ attempts_left: null }), "No limit");
});

test("what is ended now admits nobody any more, whatever its terms were", () => {
  for (const before of [terms(0, 0), terms(0, 20 * day), terms(0, 5 * day, true)]) {
    assert.equal(phaseOf(endedTerms(before, 10 * day), 10 * day + 1), "closed");
  }
});
