import assert from "node:assert/strict";
import { test } from "node:test";
import type { ToothPlan } from "../../tooth/messages";
import { depthsOf, withColumns } from "./cut";

// 4 x 3 mm from (-1, -1) in cells of half a millimetre, flat at z = 2 mm.
const kPlan: ToothPlan = {
  shade: new Uint8Array(48).fill(200),
  frontMm: new Float32Array(48).fill(2),
  width: 8,
  height: 6,
  cellMm: 0.5,
  lowMm: [-1, -1],
};
const kOrigin = [0, 0, 3] as const;

test("columns are added to those that are known, and a recording that began again has its own", () => {
  const first = withColumns(undefined, { chunks: 3, cell_um: 250, columns: [[0, -1, -1500, 0]] });
  assert.deepEqual([...first.columns.values()], [[0.125, -0.125, -1.5, 0]]);
  const second = withColumns(first, {
    chunks: 5,
    cell_um: 250,
    columns: [
      [0, -1, -2000, 0],
      [4, 0, -1200, 1],
    ],
  });
  assert.deepEqual(
    [...second.columns.values()],
    [
      [0.125, -0.125, -2, 0],
      [1.125, 0.125, -1.2, 1],
    ],
  );
  assert.equal(withColumns(second, { chunks: 1, cell_um: 250, columns: [[0, 0, 0, 0]] }).columns.size, 1);
});

test("the bur's width is cut as deep as its tip went, measured from the start tooth's surface", () => {
  // At (1.125, 0.125), 1.5 mm below the device's origin: z is 1.5, half a millimetre into the tooth.
  const cut = withColumns(undefined, { chunks: 1, cell_um: 250, columns: [[4, 0, -1500, 1]] });
  const depth = depthsOf(kPlan, cut, kOrigin, [0.1, 0.7]);
  const at = (x: number, y: number) => depth[(5 - Math.floor((y + 1) / 0.5)) * 8 + Math.floor((x + 1) / 0.5)]!;
  assert.ok(Math.abs(at(1.1, 0.1) - 0.5) < 1e-6);
  assert.ok(at(1.6, 0.1) > 0 && at(0.7, 0.1) > 0 && at(1.1, 0.6) > 0 && at(1.1, -0.4) > 0, "within its radius");
  assert.equal(at(2.1, 0.1), 0);
  assert.equal(at(-0.9, -0.9), 0);
});

test("a tip on the surface has cut nothing, nor one beside the tooth", () => {
  const beside = { ...kPlan, frontMm: new Float32Array(48).fill(-Infinity) };
  const on = withColumns(undefined, { chunks: 1, cell_um: 250, columns: [[4, 0, -1050, 0]] });
  assert.ok(depthsOf(kPlan, on, kOrigin, [0.6]).every((deep) => deep === 0));
  const deep = withColumns(undefined, {
    chunks: 1,
    cell_um: 250,
    columns: [
      [4, 0, -2500, 0],
      [400, 400, -9000, 0],
    ],
  });
  assert.ok(depthsOf(beside, deep, kOrigin, [0.6]).every((mm) => mm === 0));
});
