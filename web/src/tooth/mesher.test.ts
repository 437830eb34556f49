import assert from "node:assert/strict";
import { test } from "node:test";
import { ChangingPart, kTriangles } from "./changing";
import { kNotCompared } from "./deviation";
import { type BlockMesh, ToothMesher } from "./mesher";
import { kBrickSamples, kDeep, kFarOut } from "./samples";
import { cross, dot, lengthOf, scaled, sub, unit, type Vec } from "./scene/vec";

// Normals against closed forms: lengths are voxels.

const kBricks = 6; // along each axis
const kEnamelSampled = 1 + 8 + kTriangles;
const kGrid = { voxelMm: 1, bricks: [kBricks, kBricks, kBricks], originMm: [0, 0, 0] } as const;
const kMiddle: Vec = [23.3, 23.6, 23.8];

// What the surface of a solid is meshed to. `distance` is below 0 inside.
function meshesOf(distance: (at: Vec) => number, bricks?: ReadonlyMap<number, Int32Array>): BlockMesh[] {
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
      grid: kGrid,
      flags: new Uint8Array(count).fill(kEnamelSampled),
      samples,
      slot: Int32Array.from(all),
      labels: new Uint8Array(0),
      labelSlot: new Int32Array(count).fill(-1),
      changing: all,
    }),
  );
  if (bricks !== undefined) mesher.deviation = { grid: kGrid, values: 0, bricks };
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

// Where two vertices of a triangle have a share of more and of less than one half, how far from the middle it is one half.
function borderOf(meshes: readonly BlockMesh[], share: (mesh: BlockMesh, vertex: number) => number): number[] {
  const out: number[] = [];
  for (const mesh of meshes)
    for (let i = 0; i < mesh.triangle.length; ++i) {
      const [a, b] = [mesh.triangle[i]!, mesh.triangle[i % 3 === 2 ? i - 2 : i + 1]!];
      const [one, other] = [share(mesh, a), share(mesh, b)];
      if (one < 0.5 === other < 0.5) continue;
      const along = (axis: number) => {
        const [from, to] = [mesh.positionMm[3 * a + axis]!, mesh.positionMm[3 * b + axis]!];
        return from + ((0.5 - one) / (other - one)) * (to - from) - kMiddle[axis]!;
      };
      out.push(Math.hypot(along(0), along(1)));
    }
  return out;
}

test("the colours of what was compared end along its border, not along its cells", () => {
  const bricks = new Map<number, Int32Array>();
  for (let b = 0; b < kBricks ** 3; ++b) {
    const [x, y] = [8 * (b % kBricks), 8 * (Math.floor(b / kBricks) % kBricks)];
    const within = (i: number) =>
      Math.hypot(x + (i & 7) + 0.5 - kMiddle[0], y + ((i >> 3) & 7) + 0.5 - kMiddle[1]) < 15;
    bricks.set(
      b,
      new Int32Array(kBrickSamples).map((_, i) => (within(i) ? 250 : kNotCompared)),
    );
  }
  const meshes = meshesOf((at) => at[2] - 23.4, bricks);
  const torn = (radii: readonly number[]) => {
    const mean = radii.reduce((sum, one) => sum + one, 0) / radii.length;
    return Math.max(...radii.map((one) => Math.abs(one - mean)));
  };
  const cells = torn(borderOf(meshes, ({ deviation }, v) => deviation![2 * v + 1]!));
  const colors = torn(borderOf(meshes, ({ colored }, v) => colored![2 * v + 1]!));
  assert.ok(cells > 0.6 && colors < 0.45, `${cells} and ${colors} voxels`);
  for (const { colored } of meshes)
    for (let i = 0; i < colored!.length; i += 2)
      assert.ok(Math.abs(colored![i]! - 0.25 * colored![i + 1]!) < 1e-6, "no value is another one at the border");
});
