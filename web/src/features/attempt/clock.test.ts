import assert from "node:assert/strict";
import { test } from "node:test";
import type { Head } from "../../tooth/timeline";
import type { Series } from "../../api/types";
import { FrameClock, seriesEndS, stepAt } from "./clock";

const head = { ticks: 1050, rateHz: 1000, frameTicks: 100, segmentFrames: 4, frames: 11 } as Head;
const gapAt3 = [Uint32Array.of(0, 0, 0, 2000), new Uint32Array(4), new Uint32Array(3)];

test("a frame ends after its ticks and every gap before; the last one may be shorter", () => {
  const clock = new FrameClock(head, gapAt3);
  assert.deepEqual(
    [0, 1, 3, 4, 10, 11].map((frames) => clock.timeOf(frames)),
    [0, 0.1, 0.3, 2.4, 3, 3.05],
  );
  assert.equal(clock.endS, 3.05);
});

test("a time finds the frame whose end is nearest, and a frame's own time finds that frame", () => {
  const clock = new FrameClock(head, gapAt3);
  for (let frames = 0; frames <= 11; ++frames) assert.equal(clock.framesAt(clock.timeOf(frames)), frames);
  assert.deepEqual(
    [-5, 0.04, 0.06, 1, 2, 99].map((timeS) => clock.framesAt(timeS)),
    [0, 0, 1, 3, 4, 11],
  );
});

test("gaps name the frame in which they end, also where segments are still to come", () => {
  assert.deepEqual(new FrameClock(head, gapAt3.slice(0, 1)).gaps, [{ frames: 4, seconds: 2, endS: 2.4 }]);
});

test("thirty seconds are thirty seconds, also where a step of the series is longer than a frame", () => {
  const clock = new FrameClock({ ticks: 600_000, rateHz: 1000, frameTicks: 100, frames: 6000 } as Head, []);
  assert.equal(clock.timeOf(clock.framesAt(30)), 30);
});

test("a time is in the step that began last", () => {
  const series = { rate_hz: 1000, step_ticks: 300, t_s: [0, 0.3, 0.6, 5.6] } as unknown as Series;
  assert.deepEqual(
    [-1, 0, 0.29, 0.3, 0.6, 5, 5.6, 99].map((timeS) => stepAt(series, timeS)),
    [0, 0, 0, 1, 2, 2, 3, 3],
  );
  assert.ok(Math.abs(seriesEndS(series) - 5.9) < 1e-9);
});
