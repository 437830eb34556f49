import assert from "node:assert/strict";
import { test } from "node:test";
import { keepTrying } from "./keep_trying";

const away = (): Promise<never> => Promise.reject(new Error("away"));

test("what could not be loaded is loaded again by itself, less and less often", async () => {
  const waited: number[] = [];
  let asked = 0;
  let failed = 0;
  const there = await keepTrying(
    () => (++asked < 4 ? away() : Promise.resolve("part")),
    new AbortController().signal,
    () => ++failed,
    (again, afterMs) => {
      waited.push(afterMs);
      queueMicrotask(again);
      return () => {};
    },
  );
  assert.equal(there, "part");
  assert.deepEqual([asked, failed, waited], [4, 3, [1_000, 2_000, 4_000]]);
});

test("nothing is loaded for what is no longer shown", async () => {
  const shown = new AbortController();
  let stopped = 0;
  void keepTrying(
    away,
    shown.signal,
    () => {},
    () => () => ++stopped,
  );
  await new Promise(setImmediate);
  shown.abort();
  assert.equal(stopped, 1);
});
