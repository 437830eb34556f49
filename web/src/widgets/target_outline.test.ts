import assert from "node:assert/strict";
import { test } from "node:test";

import { outlinePaths, outlineViewBox } from "./target_outline";

const kBox = {
  landmark: "occlusal_centre",
  tooth: 46,
  up: "occlusal" as const,
  landmark_um: [0, 0, 0],
  half_size_um: [2000, 1200, 0] as [number, number, number],
  depth_um: 2000,
  leeway_side_um: 250,
  leeway_bottom_um: 250,
  container_um: 500,
  prepared: false,
  parts: [],
} satisfies Parameters<typeof outlinePaths>[0];

test("a target without parts is drawn as its box", () => {
  assert.deepEqual(outlinePaths(kBox), [{ what: "goes", d: "M -2000 1200 L 2000 1200 L 2000 -1200 L -2000 -1200 Z" }]);
  assert.equal(outlineViewBox(kBox), "-2550 -1750 5100 3500");
});

test("a disc is drawn as a circle, not as the square around it", () => {
  const paths = outlinePaths({
    ...kBox,
    parts: [{ outline: "disc", top_um: [100, 200, 0], radius_um: 500, depth_um: 700 }],
  });
  assert.deepEqual(paths, [{ what: "goes", d: "M -400 -200 A 500 500 0 0 0 600 -200 A 500 500 0 0 0 -400 -200 Z" }]);
});

test("a polygon keeps its corners", () => {
  const paths = outlinePaths({
    ...kBox,
    parts: [
      {
        outline: "polygon",
        top_um: [0, 0, 0],
        corners_um: [
          [0, 0],
          [900, 0],
          [0, 600],
        ],
        depth_um: 700,
      },
    ],
  });
  assert.deepEqual(paths, [{ what: "goes", d: "M 0 0 L 900 0 L 0 -600 Z" }]);
});

test("a stump stays: its foot and its table", () => {
  const section = (half: number) => ({
    middle_um: [0, 0] as [number, number],
    half_um: [half, half] as [number, number],
  });
  const paths = outlinePaths({
    ...kBox,
    parts: [
      {
        outline: "stump",
        top_um: [0, 0, 0],
        half_size_um: [2000, 1200],
        depth_um: 2000,
        stump: { foot: section(900), table: section(600), table_below_um: 500, corner_um: 0 },
      },
    ],
  });
  assert.deepEqual(
    paths.map((path) => path.what),
    ["goes", "stays", "stays"],
  );
  assert.equal(paths[2]?.d, "M -600 600 L 600 600 L 600 -600 L -600 -600 Z");
});
