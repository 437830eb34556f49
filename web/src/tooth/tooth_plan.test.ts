import assert from "node:assert/strict";
import { test } from "node:test";
import type { Surface } from "./surface";
import { toothPlan } from "./tooth_plan";

const kFromAbove = { right: 0, up: 1 } as const;
const kFromSide = { right: 0, up: 2 } as const;

// Two squares of 4 mm, one above the other and 4 mm to the side.
function squares(): Surface {
  const square = (z: number, shiftMm: number) => [
    [shiftMm - 2, -2, z],
    [shiftMm + 2, -2, z],
    [shiftMm + 2, 2, z],
    [shiftMm - 2, 2, z],
  ];
  const places = [...square(0, 0), ...square(3, 4)];
  const up = [0, 0, 127, 0];
  return {
    positionMm: new Float32Array(places.flat()),
    normal: new Int8Array([...Array(4).fill([0, 127, 0, 0]).flat(), ...Array(4).fill(up).flat()]),
    tissue: new Uint8Array(8),
    deviationMm: undefined,
    triangle: new Uint32Array([0, 1, 2, 0, 2, 3, 4, 5, 6, 4, 6, 7]),
  };
}

const shadeAt = (plan: ReturnType<typeof toothPlan>, x: number, y: number) => {
  const column = Math.floor((x - plan.lowMm[0]) / plan.cellMm);
  const row = plan.height - 1 - Math.floor((y - plan.lowMm[1]) / plan.cellMm);
  return plan.shade[row * plan.width + column]!;
};

test("a tooth from above lies where its scene has it, and what is higher hides what is lower", () => {
  const plan = toothPlan(squares(), kFromAbove);
  assert.deepEqual(plan.lowMm, [-2, -2]);
  assert.ok(Math.abs(plan.width * plan.cellMm - 8) < 2 * plan.cellMm, "8 mm wide");
  assert.ok(Math.abs(plan.height * plan.cellMm - 4) < 2 * plan.cellMm, "4 mm high");
  const [lower, upper] = [shadeAt(plan, -1, 0), shadeAt(plan, 4, 0)];
  assert.ok(lower > 0 && upper > lower, `${lower} and ${upper}: what faces the eye is brighter`);
});

test("from the side, the crown is shown as far down as the tooth is wide", () => {
  const { positionMm, ...others } = squares();
  const upright = positionMm.map((_, i) => (i % 3 === 2 ? positionMm[i - 1]! * 5 : i % 3 === 1 ? 0 : positionMm[i]!));
  const plan = toothPlan({ positionMm: upright, ...others }, kFromSide);
  assert.ok(Math.abs(plan.lowMm[1] - (10 - 1.2 * 8)) < 1e-6, `${plan.lowMm[1]} mm`);
  assert.ok(shadeAt(plan, 4, 9) > 0);
  assert.equal(shadeAt(plan, -1, 9) > 0, true);
});

test("from behind, right and left change sides, and what was hidden is in front", () => {
  const { normal, ...others } = squares();
  const both = { ...others, normal: normal.map((part) => -part) };
  const plan = toothPlan(both, { ...kFromAbove, against: [true, false] });
  assert.deepEqual(plan.lowMm, [-6, -2]);
  assert.ok(shadeAt(plan, -4, 0) > 0 && shadeAt(plan, 1, 0) > 0);
  const cell = (x: number) => {
    const row = plan.height - 1 - Math.floor((0 - plan.lowMm[1]) / plan.cellMm);
    return plan.frontMm[row * plan.width + Math.floor((x - plan.lowMm[0]) / plan.cellMm)];
  };
  assert.deepEqual(
    [cell(1), cell(-4)].map((mm = Number.NaN) => Math.abs(Math.round(mm))),
    [0, 3],
  );
});
