import assert from "node:assert/strict";
import { test } from "node:test";
import { golden, value } from "../golden.test";
import { decodeInterior } from "../interior";
import { pixelsOf, rowsToSlice, sliceAround } from "./cut_fill";
import type { Plane } from "./plane_cut";
import { Sight } from "./sight";
import { add, dot, scaled, unit, type Vec } from "./vec";

const kSize = [640, 480] as const;

function turned(): Sight {
  const sight = new Sight({ direction: [0.5, -0.6, 0.9], centre: [0, 0, 0] }, () => undefined);
  sight.setExtent({ centreMm: [0.3, -0.2, 0.1], radiusMm: 2 });
  sight.resize(...kSize);
  sight.rotate(0.4, -0.2);
  return sight;
}

// Where the picture shows a place, in its pixels from the lower left corner.
function pixelOf(sight: Sight, place: Vec): readonly [number, number, number] {
  const m = sight.picture;
  const [x, y, , w] = [0, 1, 2, 3].map(
    (row) => m[row]! * place[0] + m[row + 4]! * place[1] + m[row + 8]! * place[2] + m[row + 12]!,
  ) as [number, number, number, number];
  return [((x / w + 1) / 2) * kSize[0], ((y / w + 1) / 2) * kSize[1], 1];
}

test("each pixel takes its colour from the place of the plane that it shows", () => {
  const sight = turned();
  const normal = unit([0.3, -0.8, 0.5]);
  const plane: Plane = [...normal, 0.4];
  const slice = sliceAround(plane, [0.3, -0.2, 0.1], 2);
  assert.ok(Math.abs(dot(normal, slice.middle) + plane[3]) < 1e-12, "its middle is on the plane");
  const rows = rowsToSlice(slice, plane, sight.eye, (right, up) => sight.wayThrough(right, up), kSize);
  for (const [u, v] of [
    [0, 0],
    [1.2, -0.7],
    [-1.9, 0.4],
    [0.6, 1.9],
  ] as const) {
    const at = pixelOf(sight, add(slice.middle, add(scaled(slice.right, u), scaled(slice.up, v))));
    const [s, t, w] = [0, 3, 6].map((row) => dot(rows.slice(row, row + 3) as unknown as Vec, at)) as [
      number,
      number,
      number,
    ];
    assert.ok(Math.abs(s / w - (0.5 + u / 4)) < 1e-9);
    assert.ok(Math.abs(t / w - (0.5 + v / 4)) < 1e-9);
  }
});

test("a slice through the middle of a ball is a disc of dentin in one of enamel", async () => {
  const interior = value(await decodeInterior(golden("entb")));
  const plane: Plane = [0, 1, 0, 0];
  const { across, pixels } = pixelsOf(interior, sliceAround(plane, [0, 0, 0], 1.95));
  const color = (share: number) => {
    const at = 4 * (Math.floor(across / 2) * across + Math.floor(((share + 1) / 2) * across));
    return [...pixels.slice(at, at + 4)];
  };
  assert.deepEqual(color(0), [0xe2, 0xbb, 0x74, 255], "dentin within 0.9 mm");
  assert.deepEqual(color(0.35), [0xe2, 0xbb, 0x74, 255]);
  assert.deepEqual(color(0.6), [0xf2, 0xea, 0xd6, 255], "enamel around it");
  assert.deepEqual(color(-0.65), [0xf2, 0xea, 0xd6, 255]);
});
