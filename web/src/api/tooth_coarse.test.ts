import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";
import { decodeHead, decodeStartTooth, TimelinePlayer } from "./timeline";
import { coarsened, merged } from "./tooth_coarse";
import { type BlockMesh, kCells, ToothMesher } from "./tooth_mesh";

const golden = (name: string) => new Uint8Array(readFileSync(`../schemas/golden/surface_timeline.${name}`)).buffer;

// The golden tooth before it is cut: a ball of 1.43 mm at voxels of 0.1 mm, in eight blocks.
async function ball(isCoarse: (block: number) => boolean): Promise<BlockMesh[]> {
  const [head, start] = [await decodeHead(golden("entl")), await decodeStartTooth(golden("entb"))];
  assert.ok(head.ok && head.value !== undefined && start.ok);
  const mesher = new ToothMesher(new TimelinePlayer(head.value, start.value));
  return mesher.allBlocks().flatMap((block) => {
    const mesh = mesher.mesh(block);
    return mesh === undefined ? [] : [isCoarse(block) ? coarsened(mesh, mesher.cells(), kCells) : mesh];
  });
}

function corners({ positionMm, triangle }: BlockMesh): string[] {
  return Array.from(triangle, (v) => [0, 1, 2].map((axis) => positionMm[3 * v + axis]!.toFixed(6)).join());
}

function openEdges(meshes: readonly BlockMesh[]): string[] {
  const edges = new Map<string, number>();
  for (const mesh of meshes) {
    const at = corners(mesh);
    for (let t = 0; t < at.length; t += 3) {
      for (let e = 0; e < 3; ++e) {
        const [from, to] = [at[t + e]!, at[t + ((e + 1) % 3)]!];
        const [key, sign] = from < to ? [`${from} ${to}`, 1] : [`${to} ${from}`, -1];
        edges.set(key, (edges.get(key) ?? 0) + sign);
      }
    }
  }
  return [...edges].filter(([, sum]) => sum !== 0).map(([edge]) => edge);
}

test("a coarse tooth has a fraction of the triangles, and lies where the fine one does", async () => {
  const [fine, coarse] = [merged(await ball(() => false)), merged(await ball(() => true))];
  assert.ok(
    coarse.triangle.length < 0.4 * fine.triangle.length,
    `${coarse.triangle.length} of ${fine.triangle.length}`,
  );
  const off = (mesh: BlockMesh) =>
    Math.max(
      ...Array.from(mesh.tissue, (_, v) =>
        Math.abs(Math.hypot(mesh.positionMm[3 * v]!, mesh.positionMm[3 * v + 1]!, mesh.positionMm[3 * v + 2]!) - 1.43),
      ),
    );
  // (6 · 0.1 mm)² / (8 · 1.43 mm) = 0.031 mm, on the diagonal of a cube up to three times that.
  assert.ok(off(coarse) < off(fine) + 3 * 0.031, `${off(coarse)} mm`);
  for (let v = 0; v < coarse.tissue.length; ++v) {
    const [p, n] = [coarse.positionMm.slice(3 * v, 3 * v + 3), coarse.normal.slice(4 * v, 4 * v + 3)];
    assert.ok(
      (p[0]! * n[0]! + p[1]! * n[1]! + p[2]! * n[2]!) / (Math.hypot(...p) * Math.hypot(...n)) > 0.98,
      "normals point away from the middle",
    );
  }
});

test("no gap opens between coarse blocks, nor between a coarse and a fine one", async () => {
  for (const isCoarse of [() => true, (block: number) => block % 2 === 0, (block: number) => block < 3])
    assert.deepEqual(openEdges(await ball(isCoarse)), []);
});

test("several meshes as one have the triangles of all", async () => {
  const parts = await ball(() => false);
  assert.deepEqual(corners(merged(parts)).sort(), parts.flatMap(corners).sort());
});
