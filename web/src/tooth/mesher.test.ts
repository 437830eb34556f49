import assert from "node:assert/strict";
import { test } from "node:test";
import { ChangingPart, kTriangles } from "./changing";
import { type BlockMesh, ToothMesher } from "./mesher";
import { kBrickSamples, kDeep, kFarOut } from "./samples";
import { cross, dot, lengthOf, scaled, sub, unit, type Vec } from "./scene/vec";

// Normals against closed forms: lengths are voxels.

const kBricks = 6; // along each axis
const kEnamelSampled = 1 + 8 + kTriangles;
const kMiddle: Vec = [23.3, 23.6, 23.8];

// What the surface of a solid is meshed to. `distance` is below 0 inside.
function meshesOf(distance: (at: Vec) => number): BlockMesh[] {
  const count = kBricks ** 3;
  const samples = new Int8Array(count * kBrickSamples);
  for (let b = 0; b < count; ++b)
    for (let i = 0; i < kBrickSamples; ++i) {
      const at: Vec = [
        8 * (b % kBricks) + (i & 7),
        8 * (Math.floor(b / kBricks) % kBricks) + ((i >> 3) & 7),
        8 * Math.floor(b / kBricks ** 2) + (i >> 6),
      ];
      samples[b * kBrickSamples + i] = Math.max(kDeep, Math.min(kFarOut, Math.floor(64 * distance(at))));
    }
  const all = Uint32Array.from({ length: count }, (_, b) => b);
  const mesher = new ToothMesher(
    new ChangingPart({
      grid: { voxelMm: 1, bricks: [kBricks, kBricks, kBricks], originMm: [0, 0, 0] },
      flags: new Uint8Array(count).fill(kEnamelSampled),
      samples,
      slot: Int32Array.from(all),
      labels: new Uint8Array(0),
      labelSlot: new Int32Array(count).fill(-1),
      changing: all,
    }),
  );
  return mesher.allBlocks().flatMap((block) => mesher.mesh(block) ?? []);
}

// Calls each(place, normal) for the vertices away from the grid's border, where the solid is cut off.
function eachVertex(meshes: readonly BlockMesh[], each: (at: Vec, normal: Vec) => void): void {
  const of = (from: Float32Array | Int8Array, i: number): Vec => [from[i]!, from[i + 1]!, from[i + 2]!];
  for (const { positionMm, normal, tissue } of meshes)
    tissue.forEach((_, i) => {
      const at = of(positionMm, 3 * i);
      if (Math.min(...at) > 3 && Math.max(...at) < 8 * kBricks - 4) each(at, unit(of(normal, 4 * i)));
    });
}

const degrees = (cosine: number) => (Math.acos(Math.min(1, Math.max(-1, cosine))) * 180) / Math.PI;

test("normals of ball and torus are those of the closed form", () => {
  const axis = unit([1, 2, 3]);
  const fromRing = (at: Vec, radius: number): Vec => {
    const out = sub(at, kMiddle);
    const flat = sub(out, scaled(axis, dot(out, axis)));
    return sub(out, scaled(unit(flat), radius));
  };
  for (const [name, most, from, thickness] of [
    ["a ball as small as a bur", 2.5, (at: Vec) => sub(at, kMiddle), 5],
    ["a torus", 2.5, (at: Vec) => fromRing(at, 11), 4],
  ] as const) {
    let [count, worst] = [0, 0];
    eachVertex(
      meshesOf((at) => lengthOf(from(at)) - thickness),
      (at, normal) => {
        ++count;
        worst = Math.max(worst, degrees(dot(normal, unit(from(at)))));
      },
    );
    assert.ok(count > 300 && worst < most, `${name}: ${count} vertices, ${worst} degrees`);
  }
});

// A block's face into which a cylinder is cut: its wall, its rim, and the face around it.
test("along the rim of a cut normals lean to neither side of it", () => {
  const [face, axis] = [unit([0.2, 0.3, 1]), unit([-0.1, 0.25, 1])];
  const fromAxis = (at: Vec): Vec => {
    const out = sub(at, kMiddle);
    return sub(out, scaled(axis, dot(out, axis)));
  };
  const [above, inside] = [
    (at: Vec) => dot(sub(at, kMiddle), face),
    (at: Vec) => 9 - lengthOf(fromAxis(at)), // above 0 in the hole
  ];
  let [rim, walls, leaning, off] = [0, 0, 0, 0];
  eachVertex(
    meshesOf((at) => Math.max(above(at), inside(at))),
    (at, normal) => {
      const wall = scaled(unit(fromAxis(at)), -1);
      const [up, out] = [above(at), inside(at)];
      if (Math.abs(up) < 2 && Math.abs(out) < 2) {
        ++rim;
        leaning = Math.max(leaning, Math.abs(90 - degrees(dot(normal, unit(cross(face, wall))))));
      } else if (Math.min(Math.abs(up), Math.abs(out)) < 0.2) {
        ++walls;
        if (Math.max(Math.abs(up), Math.abs(out)) > 3)
          off = Math.max(off, degrees(dot(normal, Math.abs(up) < 0.2 ? face : wall)));
      }
    },
  );
  assert.ok(rim > 100 && walls > 500, `${rim} vertices at the rim, ${walls} beside it`);
  assert.ok(leaning < 8, `${leaning} degrees along the rim`);
  assert.ok(off < 2.5, `${off} degrees off face and wall`);
});
