import assert from "node:assert/strict";
import { test } from "node:test";
import type { LiveRow } from "../../api/live";
import { liveTime, recentFaults } from "./live_time";
import { emptyTrack } from "./track";

test("the remaining time is shown, or the time over the limit", () => {
  assert.deepEqual(liveTime(200_000, 1000, 600), {
    text: "6\u00a0min\u00a040\u00a0s left of 10\u00a0min\u00a000\u00a0s",
    share: 1 / 3,
    over: false,
  });
  assert.deepEqual(liveTime(330_000, 500, 600), {
    text: "1\u00a0min\u00a000\u00a0s over 10\u00a0min\u00a000\u00a0s",
    share: 1,
    over: true,
  });
  assert.deepEqual(liveTime(12_300, 1000, 0), { text: "12\u00a0s, no time limit", share: undefined, over: false });
});

test("a fault stays in sight for as long as the strip shows it", () => {
  const row = (tick: number, flags: number): LiveRow => ({ tick, anchorMm: [0, 0, 0], forceN: [0, 0, 0], flags });
  assert.deepEqual(recentFaults({ ...emptyTrack, rows: [row(1, 2048), row(2, 2), row(3, 0)] }), [
    "Peak limited",
    "Fault: step too long",
  ]);
  assert.deepEqual(recentFaults(emptyTrack), []);
});
