import assert from "node:assert/strict";
import { test } from "node:test";
import { Matrix4, Quaternion, Vector3 } from "three";
import { inverse, kUnturned, placed, product, type Quat, turnBetween, turned, unit, type Vec, viewFrom } from "./vec";

const kWays: readonly Vec[] = [[0, 0, 1], [0, 1, 0], [0, -1, 0], [0, 0, -1], unit([1, 2, -3]), unit([-1, -2, 3])];

function near(mine: readonly number[], theirs: readonly number[], what: string): void {
  for (const [i, value] of mine.entries())
    assert.ok(Math.abs(value - theirs[i]!) < 1e-12, `${what}: ${mine} and ${theirs}`);
}

test("turns are those of three, also between opposite directions", () => {
  for (const from of kWays)
    for (const to of kWays) {
      const turn = turnBetween(from, to);
      const theirs = new Quaternion().setFromUnitVectors(new Vector3(...from), new Vector3(...to));
      near(turned(turn, from), to, `${from} to ${to}`);
      near(turned(turn, [1, -2, 3]), new Vector3(1, -2, 3).applyQuaternion(theirs).toArray(), `${from} to ${to}`);
      near(turned(inverse(turn), to), from, `${to} back to ${from}`);
    }
});

test("placing and joining matrices is as in three", () => {
  const turn: Quat = turnBetween(kWays[0]!, kWays[4]!);
  const mine = placed(turn, [1, 2, 3], [2, 3, 4]);
  const theirs = new Matrix4().compose(new Vector3(1, 2, 3), new Quaternion(...turn), new Vector3(2, 3, 4));
  near(mine, theirs.toArray(), "placed");
  const other = placed(kUnturned, [-4, 5, 6]);
  near(product(mine, other), theirs.multiply(new Matrix4().makeTranslation(-4, 5, 6)).toArray(), "product");
});

test("a camera straight above sees the scene, though nothing is up in its picture", () => {
  for (const up of [
    [0, 0, 1],
    [0, 1, 0],
  ] as const)
    for (const value of viewFrom([10 * up[0], 10 * up[1], 10 * up[2]], [0, 0, 0], up))
      assert.ok(Number.isFinite(value));
});
