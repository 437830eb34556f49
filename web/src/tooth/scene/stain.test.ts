import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";
import { goldenPlayer } from "../golden.test";
import { ToothMesher } from "../mesher";
import { kStainColor, tissueColor } from "../tissue_color";
import { kCutFlag, kFrom, kFull, kMaxStained, kStainSteps, withStain } from "./stain";

// A fold along y: two planes 0.1 mm wide, whose vertices' normals lean by `lean` (127 = 1) toward it.
function fold(lean: number, cut?: Uint8Array<ArrayBuffer>) {
  const at = [-0.1, 0, 0.1].flatMap((x) => [x, 0, 0, x, 1, 0]);
  const toward = [lean, lean, 0, 0, -lean, -lean];
  return {
    positionMm: Float32Array.from(at),
    normal: Int8Array.from(toward.flatMap((x) => [x, 0, 120, 0])),
    tissue: Uint8Array.from([1, 1, 1, 1, 2, 2]),
    deviation: undefined,
    triangle: Uint16Array.from([0, 2, 1, 1, 2, 3, 2, 4, 3, 3, 4, 5]),
    ...(cut === undefined ? {} : { cut }),
  };
}

test("a groove of enamel is stained, a ridge is not", () => {
  // The normals turn by 60 / 127 within 0.1 mm: 4.7 per mm.
  assert.deepEqual([...withStain(fold(60))].slice(2), [1 + 8 * kStainSteps, 1 + 8 * kStainSteps, 2, 2]);
  assert.deepEqual([...withStain(fold(-60))], [1, 1, 1, 1, 2, 2]);
  assert.deepEqual([...withStain(fold(10))], [1, 1, 1, 1, 2, 2], "0.8 per mm");
});

test("a groove that a bur cut is matt and has no stain", () => {
  assert.deepEqual([...withStain(fold(60, Uint8Array.of(0, 0, 1, 1, 0, 0)))].slice(2, 4), [1 + kCutFlag, 1 + kCutFlag]);
});

test("nothing is cut before the first tick, and at the end what the bur left", async () => {
  const player = await goldenPlayer();
  const cutOf = () => {
    const mesher = new ToothMesher(player);
    return mesher
      .allBlocks()
      .flatMap((block) => [...(mesher.mesh(block)?.cut ?? [])])
      .filter((one) => one !== 0).length;
  };
  assert.equal(cutOf(), 0);
  player.seek(player.head.frames);
  assert.ok(cutOf() > 50);
});

test("colours and grooves are those of the chair's picture", () => {
  const tissues = ["enamel", "dentin", "pulp", "caries"].map((name, i) => `${name} ${tissueColor(i + 1)}`);
  const lines = [...tissues, `stain ${kStainColor}`, `groove_from_per_mm ${kFrom}`, `groove_full_per_mm ${kFull}`];
  const found = [...lines, `most_stained ${kMaxStained}`, ""].join("\n");
  assert.equal(found, readFileSync("../schemas/golden/tooth_look.txt", "utf8"));
});
