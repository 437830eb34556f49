import assert from "node:assert/strict";
import { test } from "node:test";
import { Rotation } from "./rotation";

function rotation(most: number) {
  const open = new Set<string>();
  const started: string[] = [];
  const pool = new Rotation(most, (id) => {
    assert.ok(!open.has(id), `${id} twice`);
    open.add(id);
    started.push(id);
    return () => open.delete(id);
  });
  return { pool, open, started };
}

test("few are all followed at once, and stay so", () => {
  const { pool, open, started } = rotation(3);
  pool.follow(["a", "b"]);
  pool.turn();
  pool.turn();
  assert.deepEqual([...open], ["a", "b"]);
  assert.deepEqual(started, ["a", "b"]);
});

test("of many, never more than allowed are open, and each has its turn", () => {
  const { pool, open, started } = rotation(3);
  const ids = Array.from({ length: 42 }, (_, i) => `s${i}`);
  pool.follow(ids);
  for (let i = 0; i < 39; ++i) {
    assert.equal(open.size, 3);
    pool.turn();
  }
  assert.deepEqual([...new Set(started)].sort(), [...ids].sort());
});

test("a stream without its attempt is closed and another takes its place", () => {
  const { pool, open } = rotation(2);
  pool.follow(["a", "b", "c"]);
  pool.follow(["b", "c"]);
  assert.deepEqual([...open].sort(), ["b", "c"]);
  pool.dispose();
  assert.equal(open.size, 0);
});
