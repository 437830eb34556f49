import assert from "node:assert/strict";
import { test } from "node:test";
import type { AttemptFlag } from "../api/types";
import { flagText, shownFlags } from "./attempt_state";

test("how the station ran is shown to staff, calmly, and not to students", () => {
  const flags: readonly AttemptFlag[] = ["late", "faster_than_time", "contradicted"];
  assert.deepEqual(shownFlags(flags, true), flags);
  assert.deepEqual(shownFlags(flags, false), ["late"]);
  assert.equal(flagText("faster_than_time").tone, "neutral");
});
