import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";
import type { Interior } from "../interior";
import { kLesionColors, tissueColor } from "../tissue_color";
import { type Rgb, linearColor } from "./colors";
import { kFigures, kScattered, Looks, overDark, throughEnamel } from "./looks";

const kVoxelMm = 0.05;
const kBricks = 16; // along each axis
const kMiddle = (kBricks * 8 * kVoxelMm) / 2;
const kUp = 40; // of the surface, above the middle: voxels

// Layers below a plane, from the surface down: tissue and mm. Air above and below them.
function layers(...below: readonly (readonly [number, number])[]): Interior {
  const flags = new Uint8Array(kBricks ** 3).fill(16);
  const labels = new Uint8Array(flags.length * 512);
  for (let brick = 0; brick < flags.length; ++brick)
    for (let i = 0; i < 512; ++i) {
      const z = Math.floor(brick / kBricks ** 2) * 8 + (i >> 6);
      let depthMm = (kBricks * 4 + kUp - z) * kVoxelMm;
      if (depthMm < 0) continue;
      for (const [tissue, mm] of below) {
        if (depthMm < mm) {
          labels[512 * brick + i] = tissue;
          break;
        }
        depthMm -= mm;
      }
    }
  return {
    grid: { voxelMm: kVoxelMm, bricks: [kBricks, kBricks, kBricks], originMm: [0, 0, 0] },
    flags,
    labels,
    labelSlot: Int32Array.from(flags, (_, brick) => brick),
  };
}

// The linear colour of a vertex of that plane, in its middle.
function colorOn(interior: Interior, tissue: number, cut = false): Rgb {
  const own = new Looks(interior).of({
    positionMm: Float32Array.of(kMiddle, kMiddle, kMiddle + kUp * kVoxelMm),
    normal: Int8Array.of(0, 0, 127, 0),
    tissue: Uint8Array.of(tissue),
    cut: Uint8Array.of(cut ? 1 : 0),
    deviation: undefined,
    triangle: new Uint16Array(),
  });
  assert.equal(own[3], 255, "is known");
  return [...own].slice(0, 3).map((root) => (root / 255) ** 2) as unknown as Rgb;
}
const warmth = ([red, , blue]: Rgb) => red / blue;
const [enamel, dentin] = [1, 2].map((tissue) => linearColor(tissueColor(tissue))) as [Rgb, Rgb];
function near(a: Rgb, b: Rgb): void {
  assert.ok(
    a.every((value, i) => Math.abs(value - b[i]!) < 0.012),
    `${a} is ${b}`,
  );
}

test("thick enamel has its own colour, thin enamel over dentin is warmer", () => {
  near(colorOn(layers([1, 4]), 1), enamel);
  const [thin, middling] = [0.4, 1.2].map((mm) => warmth(colorOn(layers([1, mm], [2, 3]), 1))) as [number, number];
  assert.ok(thin > middling && middling > warmth(enamel), `${thin}, ${middling}, ${warmth(enamel)}`);
  assert.ok(thin < warmth(dentin));
});

test("an edge of enamel alone is darker and bluer, unless a bur made it", () => {
  const edge = layers([1, 1]);
  const [color, left] = [colorOn(edge, 1), colorOn(edge, 1, true)];
  near(left, enamel);
  assert.ok(color[0] < 0.8 * enamel[0] && warmth(color) < warmth(enamel), `${color}`);
});

test("the pulp is seen through a little dentin, and not through much", () => {
  near(colorOn(layers([2, 2], [3, 2]), 2), dentin);
  const [red, green] = colorOn(layers([2, 0.4], [3, 2]), 2);
  assert.ok(red / green > (1.1 * dentin[0]) / dentin[1], `${red}, ${green}`);
});

test("a lesion begins softly", () => {
  const depths = [0.6, 0.2, 0.1, 0].map((mm) => colorOn(layers([2, mm], [4, 3]), mm === 0 ? 4 : 2)[1]);
  assert.deepEqual(
    depths,
    [...depths].sort((a, b) => b - a),
    `${depths}`,
  );
  assert.ok(depths[0]! - depths[3]! > 0.2);
});

test("the figures are those of the chair's picture", () => {
  const chair = readFileSync("../station/render/tooth_looks.cpp", "utf8");
  const found = (name: string) => Number(new RegExp(`\\b${name} = (-?[0-9.e-]+)`).exec(chair)?.[1]);
  for (const [name, figure] of Object.entries(kFigures)) {
    const here = found(`${name}_m`) * 1000 || found(name);
    assert.ok(Math.abs(here - figure) < 1e-9, `${name}: ${here} at the chair, ${figure} here`);
  }
  for (const [name, pair] of [
    ["Enamel", kScattered.enamel],
    ["Dentin", kScattered.dentin],
  ] as const)
    assert.ok(chair.includes(`k${name}_per_mm = Exchanged_per_mm(${pair.join(", ")});`), name);
  const lesion = kLesionColors.map((hex) =>
    hex
      .match(/[0-9a-f]{2}/g)!
      .map((two) => Number.parseInt(two, 16))
      .join(", "),
  );
  const materials = readFileSync("../station/render/materials.cpp", "utf8");
  assert.ok(materials.includes(`Lesion() { return {Linear(${lesion[0]}), Linear(${lesion[1]})}; }`));
  assert.ok(Math.abs(throughEnamel(1) - 1 / 2.584 ** 2) < 1e-9);
  assert.ok(overDark(1)[2] > overDark(1)[0]);
});
