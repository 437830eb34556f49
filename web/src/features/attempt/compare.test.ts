import assert from "node:assert/strict";
import { test } from "node:test";
import type { Series } from "../../api/types";
import { momentInOther } from "./compare";

const series = (t_s: number[], removed_mm3: number[]) =>
  ({ rate_hz: 1000, step_ticks: 1000, t_s, removed_mm3 }) as unknown as Series;
const own = series([0, 1, 2, 3], [0, 2, 4, 6]);

test("by time another attempt is at the same time, or at its end", () => {
  assert.equal(momentInOther("time", own, series([0, 1], [0, 9]), 1.5), 1.5);
  assert.equal(momentInOther("time", own, series([0, 1], [0, 9]), 3.5), 2);
});

test("at the end of one, another attempt that took longer is at its end too", () => {
  const longer = series([0, 1, 2, 3, 4, 5], [0, 1, 2, 3, 4, 5]);
  for (const sync of ["time", "removed", "path"] as const)
    assert.equal(
      momentInOther(sync, own, longer, 4, () => 2),
      6,
      sync,
    );
});

test("by removed volume it is where as much was first gone", () => {
  const slow = series([0, 1, 2, 3, 4, 5], [0, 1, 2, 2, 4, 5]);
  assert.deepEqual(
    [0, 1, 1.9, 2].map((timeS) => momentInOther("removed", own, slow, timeS)),
    [0, 2, 2, 4],
  );
  assert.equal(momentInOther("removed", own, slow, 3), 6, "it never removed as much");
  assert.equal(momentInOther("removed", own, slow, 4), 6, "the end is the end");
});

test("by the way it is where the two ways are aligned, and nowhere before that is known", () => {
  assert.equal(momentInOther("path", own, own, 1.5), undefined);
  assert.equal(
    momentInOther("path", own, own, 1.5, (timeS) => 3 * timeS),
    4.5,
  );
});
