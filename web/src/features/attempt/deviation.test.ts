import assert from "node:assert/strict";
import { test } from "node:test";
import type { Compared } from "../../tooth/messages";
import { outlook, summariseDeviation } from "./deviation";

type Vertex = readonly [normal: readonly [number, number, number], deviationMm: number];

function surfaceOf(vertices: readonly Vertex[]): Compared {
  return {
    positionMm: new Float32Array(3 * vertices.length),
    normal: new Int8Array(vertices.flatMap(([normal]) => [...normal.map((value) => value * 127), 0])),
    deviationMm: new Float32Array(vertices.map(([, deviation]) => deviation)),
  };
}

test("a mesial wall that is 0.3 mm too deep is named first, with its sign", () => {
  const summary = summariseDeviation(
    surfaceOf([
      [[-1, 0, 0], 0.3],
      [[-1, 0, 0], 0.28],
      [[1, 0, 0], -0.02],
      [[0, 0, 1], 0.01],
      [[0, 1, 0], 0],
    ]),
    1,
  );
  assert.equal(summary?.sides[0]?.side, "mesial_wall");
  assert.ok(Math.abs(summary.sides[0].meanMm - 0.29) < 1e-6);
  assert.ok(Math.abs(summary.sides[0].mostMm - 0.3) < 1e-6);
});

test("of a lower right molar the wall at +x is the distal one, and is looked at from mesial", () => {
  const surface = surfaceOf([
    [[-1, 0, 0], 0.3],
    [[1, 0, 0], 0.1],
  ]);
  const summary = summariseDeviation(surface, -1);
  assert.deepEqual(
    summary?.sides.map(({ side }) => side),
    ["distal_wall", "mesial_wall"],
  );
  assert.ok(outlook(surface, summary?.sides[0]?.side, -1).direction[0] < 0);
});

test("which wall is mesial is not said before it is known which tooth it is", () => {
  const summary = summariseDeviation(
    surfaceOf([
      [[-1, 0, 0], 0.3],
      [[0, 0, 1], 0.1],
    ]),
    undefined,
  );
  assert.deepEqual(
    summary?.sides.map(({ side }) => side),
    ["floor"],
  );
  assert.equal(summary?.vertices, 2);
});

test("shares of more, less and within the leeway add up to the whole", () => {
  const summary = summariseDeviation(
    surfaceOf([
      [[0, 0, 1], 0.2],
      [[0, 0, 1], -0.2],
      [[0, 0, 1], 0.05],
      [[0, 0, 1], 0],
    ]),
    1,
  );
  assert.equal(summary?.overShare, 0.25);
  assert.equal(summary?.underShare, 0.25);
  assert.equal(summary?.withinShare, 0.5);
});

test("untouched vertices do not count, and nothing compared is no summary", () => {
  assert.equal(
    summariseDeviation(
      surfaceOf([
        [[0, 0, 1], Number.NaN],
        [[0, 0, 1], 0.4],
      ]),
      1,
    )?.vertices,
    1,
  );
  assert.equal(summariseDeviation(surfaceOf([[[0, 0, 1], Number.NaN]]), 1), undefined);
});

test("the view begins opposite the wall that deviates most, at the middle of what was cut", () => {
  const surface = surfaceOf([
    [[-1, 0, 0], 0.3],
    [[0, 0, 1], 0],
    [[0, 1, 0], Number.NaN],
  ]);
  surface.positionMm.set([2, 0, 1, 0, 0, -1, 90, 90, 90]);
  const { direction, centre } = outlook(surface, summariseDeviation(surface, 1)?.sides[0]?.side, 1);
  assert.ok(direction[0] < 0 && direction[2] > 0);
  assert.deepEqual(centre, [1, 0, 0]);
  assert.equal(outlook(surface, undefined, 1).centre, undefined);
});
