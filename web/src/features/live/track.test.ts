import assert from "node:assert/strict";
import { test } from "node:test";
import type { LiveRow } from "../../api/live";
import { emptyTrack, extentOf, flagTexts, kTrackSeconds, largestForce, shownSeconds, withRows } from "./track";

const row = (tick: number, x = 0, force = 0): LiveRow => ({
  tick,
  anchorMm: [x, -x, 1],
  forceN: [0, force, 0],
  flags: 0,
});
const rows = (from: number, count: number) => Array.from({ length: count }, (_, i) => row(from + 16 * i));

test("a track keeps the last seconds only, however long it is watched", () => {
  let track = emptyTrack;
  for (let i = 0; i < 600; ++i) track = withRows(track, rows(16 * 30 * i, 30), 1000, 1);
  const [first, last] = [track.rows[0]!, track.rows.at(-1)!];
  assert.ok(last.tick - first.tick <= kTrackSeconds * 1000);
  assert.ok(track.rows.length > 1000 && track.rows.length <= 2000);
});

test("ticks that go back begin a new track", () => {
  const track = withRows(withRows(emptyTrack, rows(5000, 10), 1000, 1), rows(0, 4), 1000, 2);
  assert.equal(track.rows.length, 4);
  assert.equal(track.heardMs, 2);
});

test("where the tool was and the largest force are those of the rows", () => {
  const some = [row(1, -2, 0.5), row(2, 3, 1.5)];
  assert.deepEqual(extentOf(some), { low: [-2, -3, 1], high: [3, 2, 1] });
  assert.equal(largestForce(some), 1.5);
  assert.equal(extentOf([]), undefined);
});

test("a tick without anything to say has no flag text, one with two has two", () => {
  assert.deepEqual(flagTexts(16 | 32), []);
  assert.equal(flagTexts(2 | 1024).length, 2);
  assert.equal(flagTexts(4096).length, 1);
});

test("a strip shows as much time as was seen, at least some seconds and at most those that are kept", () => {
  assert.equal(shownSeconds([], 1000), 4);
  assert.equal(shownSeconds([row(5000), row(5500)], 1000), 4);
  assert.equal(shownSeconds([row(0), row(9000)], 1000), 9);
  assert.equal(shownSeconds([row(0), row(90_000)], 1000), kTrackSeconds);
});
