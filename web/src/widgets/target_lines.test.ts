import assert from "node:assert/strict";
import { test } from "node:test";
import type { Exercise } from "../api/types";
import { crossings } from "../tooth/scene/plane_cut";
import { bodyOfTarget, borderOf, grown, linesOfTarget } from "./target_lines";

const target: Exercise["target"] = {
  landmark: "fossa",
  tooth: 46,
  up: "occlusal" as const,
  landmark_um: [1000, 2000, 5000],
  half_size_um: [2000, 1500, 0],
  depth_um: 2500,
  leeway_side_um: 250,
  leeway_bottom_um: 500,
  container_um: 800,
  prepared: false,
  parts: [],
};

test("a box is opening, floor and four edges, with a wider and deeper one around it", () => {
  const { solid, faint } = linesOfTarget(target)!;
  assert.deepEqual(solid[0], [
    [3, 3.5, 5],
    [-1, 3.5, 5],
    [-1, 0.5, 5],
    [3, 0.5, 5],
    [3, 3.5, 5],
  ]);
  assert.deepEqual(solid[1]![0], [3, 3.5, 2.5]);
  assert.equal(solid.length, 6);
  assert.deepEqual(solid[2], [
    [3, 3.5, 5],
    [3, 3.5, 2.5],
  ]);
  assert.deepEqual(faint, [
    [
      [3.25, 3.75, 5],
      [-1.25, 3.75, 5],
      [-1.25, 0.25, 5],
      [3.25, 0.25, 5],
      [3.25, 3.75, 5],
    ],
    [
      [3.25, 3.75, 2],
      [-1.25, 3.75, 2],
      [-1.25, 0.25, 2],
      [3.25, 0.25, 2],
      [3.25, 3.75, 2],
    ],
  ]);
});

test("a disc is round, a polygon has its own corners, and parts stand where they stand", () => {
  const disc = linesOfTarget({
    ...target,
    parts: [{ outline: "disc", top_um: [500, 0, -1000], radius_um: 1000, depth_um: 1000 }],
  })!;
  for (const [x, y, z] of disc.solid[0]!) {
    assert.ok(Math.abs(Math.hypot(x - 1.5, y - 2) - 1) < 1e-9);
    assert.equal(z, 4);
  }
  assert.equal(disc.solid.length, 6);
  const polygon = linesOfTarget({
    ...target,
    parts: [
      {
        outline: "polygon",
        top_um: [0, 0, 0],
        corners_um: [
          [1000, 0],
          [0, 1000],
          [-1000, 0],
        ],
        depth_um: 1000,
      },
    ],
  })!;
  assert.deepEqual(polygon.solid[0]![1], [1, 3, 5]);
  assert.equal(polygon.solid.length, 5);
});

test("a stump is its foot and its table; a floor of the tooth's own shape is drawn along the walls", () => {
  const stump = linesOfTarget({
    ...target,
    parts: [
      {
        outline: "stump",
        top_um: [0, 0, 0],
        half_size_um: [5000, 5000],
        depth_um: 6000,
        stump: {
          foot: { middle_um: [0, 100], half_um: [3000, 2000] },
          table: { middle_um: [0, 0], half_um: [2000, 1000] },
          table_below_um: 1500,
          corner_um: 400,
        },
      },
    ],
  })!;
  assert.deepEqual(stump.solid[0]![0], [4, 4.1, -1]);
  assert.deepEqual(stump.solid[1]![0], [3, 3, 3.5]);
  assert.deepEqual(stump.faint, []);
  const relief = linesOfTarget({
    ...target,
    parts: [
      {
        outline: "box",
        top_um: [0, 0, 0],
        half_size_um: [1000, 1000],
        depth_um: 900,
        relief: { step_um: 1000, count: [3, 1], below_um: [900, 300, 500] },
      },
    ],
  })!;
  const [opening, floor, edge] = relief.solid;
  assert.ok(opening!.every(([, , z]) => z === 5));
  const depthAt = (x: number, y: number) => {
    const found = floor!.find((point) => Math.abs(point[0] - x) < 1e-9 && Math.abs(point[1] - y) < 1e-9);
    return Math.round(1000 * (5 - found![2]));
  };
  assert.deepEqual([depthAt(0, 3), depthAt(0.5, 3), depthAt(1, 3), depthAt(2, 1)], [900, 600, 300, 500]);
  assert.deepEqual(edge, [opening![0], floor![0]]);
  const faintest = relief.faint[1]!.map(([, , z]) => z);
  assert.ok(Math.abs(Math.min(...faintest) - (5 - 0.9 - 0.5)) < 1e-9, "the leeway follows the floor");
});

test("a corner grows along both of its sides; without a place there are no lines", () => {
  assert.deepEqual(
    grown(
      [
        [1, 0],
        [0, 1],
        [-1, 0],
        [0, -1],
      ],
      Math.SQRT1_2,
    ).map(([x, y]) => [Math.round(1e9 * x) / 1e9, Math.round(1e9 * y) / 1e9]),
    [
      [2, 0],
      [0, 2],
      [-2, 0],
      [0, -2],
    ],
  );
  assert.equal(linesOfTarget({ ...target, landmark_um: null }), undefined);
});

// Lengths of the cut along the plane y = `atMm`.
function cutAlong(body: NonNullable<ReturnType<typeof bodyOfTarget>>, atMm: number) {
  const lines: number[] = [];
  crossings(body.positionMm, body.triangle, [0, 1, 0], -atMm, lines);
  const ends = new Map<string, number>();
  let length = 0;
  for (let i = 0; i < lines.length; i += 6) {
    length += Math.hypot(lines[i]! - lines[i + 3]!, lines[i + 2]! - lines[i + 5]!);
    for (const end of [i, i + 3]) {
      const key = [lines[end]!, lines[end + 2]!].map((mm) => mm.toFixed(4)).join();
      ends.set(key, (ends.get(key) ?? 0) + 1);
    }
  }
  return { length, closed: [...ends.values()].every((count) => count % 2 === 0) };
}

test("a plane cuts a box's body in a closed rectangle of its size", () => {
  const { length, closed } = cutAlong(bodyOfTarget(target)!, 2.2);
  assert.ok(closed);
  assert.ok(Math.abs(length - 2 * (4 + 2.5)) < 1e-4);
});

test("a plane through both arms of an outline with a notch cuts two rectangles", () => {
  // A U that is open towards +y, 3 wide, with arms 1 wide and 2 long.
  const corners = [
    [0, 0],
    [3000, 0],
    [3000, 3000],
    [2000, 3000],
    [2000, 1000],
    [1000, 1000],
    [1000, 3000],
    [0, 3000],
  ];
  const notched = {
    ...target,
    landmark_um: [0, 0, 0],
    parts: [{ outline: "polygon" as const, top_um: [0, 0, 0], corners_um: corners, depth_um: 1500 }],
  } as unknown as Exercise["target"];
  const body = bodyOfTarget(notched)!;
  const arms = cutAlong(body, 2);
  assert.ok(arms.closed);
  assert.ok(Math.abs(arms.length - 2 * 2 * (1 + 1.5)) < 1e-4, `${arms.length}`);
  assert.ok(Math.abs(cutAlong(body, 0.5).length - 2 * (3 + 1.5)) < 1e-4);
});

test("a plane cuts a floor of the tooth's own shape as it rises and falls", () => {
  const roof = {
    ...target,
    landmark_um: [0, 0, 0],
    parts: [
      {
        outline: "box" as const,
        top_um: [0, 0, 0],
        half_size_um: [1000, 1000],
        depth_um: 2000,
        relief: { step_um: 1000, count: [3, 1], below_um: [2000, 1000, 2000] },
      },
    ],
  } as unknown as Exercise["target"];
  const { length, closed } = cutAlong(bodyOfTarget(roof)!, 0.3);
  assert.ok(closed);
  assert.ok(Math.abs(length - (2 + 2 + 2 + 2 * Math.SQRT2)) < 1e-4, `${length}`);
});

test("a target whose place is not known has no body", () => {
  assert.equal(bodyOfTarget({ ...target, landmark_um: null } as unknown as Exercise["target"]), undefined);
});

test("parts that cross have one border, and a part hides the lines of another one only where it is as deep", () => {
  const bar = (half: [number, number], depth: number) => ({
    outline: "box" as const,
    top_um: [0, 0, 0] as [number, number, number],
    half_size_um: half,
    depth_um: depth,
  });
  const pieces = (...depths: [number, number]) =>
    borderOf({ ...target, parts: [bar([3000, 750], depths[0]), bar([750, 3000], depths[1])] })!.split("M ").length - 1;
  assert.equal(pieces(1500, 1500), 4);
  assert.equal(pieces(1500, 2500), 3);
  assert.equal(borderOf(target), undefined);
});
