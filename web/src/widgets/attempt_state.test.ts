import assert from "node:assert/strict";
import { test } from "node:test";
import type { AttemptFlag } from "../api/types";
import { attemptStateText, flagText, shownFlags } from "./attempt_state";

test("how the station ran is shown to staff, calmly, and not to students", () => {
  const flags: readonly AttemptFlag[] = ["late", "faster_than_time", "contradicted"];
  assert.deepEqual(shownFlags(flags, true), flags);
  assert.deepEqual(shownFlags(flags, false), ["late"]);
  assert.equal(flagText("faster_than_time").tone, "neutral");
});

test("practice that waits for a reference has not failed", () => {
  const waiting = attemptStateText({ state: "failed", problem_field: "no_reference" });
  assert.deepEqual(waiting, { title: "Waiting for a reference", tone: "neutral" });
  assert.deepEqual(attemptStateText({ state: "failed", problem_field: "replay" }), {
    title: "Scoring failed",
    tone: "bad",
  });
});
