import assert from "node:assert/strict";
import { test } from "node:test";
import { crossings } from "./plane_cut";

// An octahedron of corners at distance 1.
const position = Float32Array.of(1, 0, 0, -1, 0, 0, 0, 1, 0, 0, -1, 0, 0, 0, 1, 0, 0, -1);
const triangle = Uint16Array.of(0, 2, 4, 2, 1, 4, 1, 3, 4, 3, 0, 4, 2, 0, 5, 1, 2, 5, 3, 1, 5, 0, 3, 5);

function cut(normal: readonly [number, number, number], constant: number): number[] {
  const out: number[] = [];
  crossings(position, triangle, normal, constant, out);
  return out;
}

test("a plane above the middle cuts an octahedron in a closed square of the right size", () => {
  const lines = cut([0, 0, 1], -0.4);
  assert.equal(lines.length, 4 * 6);
  const ends = new Map<string, number>();
  for (let i = 0; i < lines.length; i += 3) {
    assert.ok(Math.abs(lines[i + 2]! - 0.4) < 1e-6);
    assert.ok(Math.abs(Math.abs(lines[i]!) + Math.abs(lines[i + 1]!) - 0.6) < 1e-6);
    const key = [lines[i]!, lines[i + 1]!].map((mm) => Math.round(mm * 1e4) + 0).join();
    ends.set(key, (ends.get(key) ?? 0) + 1);
  }
  assert.deepEqual([...ends.values()], [2, 2, 2, 2], "each corner ends two lines");
});

test("a plane beside the body cuts nothing, and one through corners still gives pairs of ends", () => {
  assert.deepEqual(cut([1, 0, 0], -2), []);
  assert.deepEqual(cut([1, 0, 0], 2), []);
  assert.equal(cut([0, 0, 1], 0).length % 6, 0);
  assert.equal(cut([1, 0, 0], 0).length % 6, 0);
});
