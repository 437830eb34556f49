import assert from "node:assert/strict";
import { test } from "node:test";
import type { FeelCell, FeelTissue, ProfileFeel } from "../../api/types";
import {
  bySpeed,
  comparable,
  dampingText,
  differences,
  feltText,
  figuresText,
  referenceText,
  speedsOf,
  tissueName,
} from "./feel";

const tissue = (damping: number, names = ["enamel"]): FeelTissue => ({
  names,
  damping_mn_s_per_mm: damping,
  coulomb_mn: 0,
  threshold_mn: 0,
  provenance: "p",
  scenes: [],
});

function cell(over: Partial<FeelCell> & { readonly gain?: number }): FeelCell {
  const { gain = 1, ...rest } = over;
  const steady = rest.motion === "steady";
  const figures = { error: 0.31, gain, lag_s: steady ? null : 0.078, rise_s: steady ? 0.83 : null };
  return {
    tissue: 0,
    speed_mm_per_s: 0.43,
    motion: "strokes",
    force_rms_n: 2,
    force_largest_n: 3,
    verdict: "device_cannot",
    law: figures,
    oracle: { ...figures, error: 0.67, gain: 0.5 },
    ...rest,
  };
}

const feel = (cells: FeelCell[], tissues = [tissue(8700)]) =>
  ({
    name: "a",
    title: "A",
    version: 1,
    has_motors: true,
    coupling_mn_per_mm: 3000,
    delay_ticks: 1,
    delay_measured: false,
    tissues,
    tissues_of_scenes: true,
    tissues_left_out: 0,
    thresholds: [
      { name: "force", value: 0.07, unit: "share", source: "s" },
      { name: "viscosity", value: 0.19, unit: "share", source: "s" },
      { name: "delay", value: 0.015, unit: "s", source: "s" },
    ],
    cells,
  }) satisfies ProfileFeel;

test("a cell says its figures in units people read", () => {
  assert.equal(figuresText(cell({})), "31\u00a0% off, 78 ms late");
  assert.equal(figuresText(cell({ motion: "steady" })), "31\u00a0% off, after 830 ms");
  assert.equal(
    figuresText(cell({ motion: "steady", law: { error: 0.5, gain: 0.5, lag_s: null, rise_s: null } })),
    "50\u00a0% off, never within 7 %",
  );
  assert.equal(figuresText(cell({ verdict: "beyond_force" })), "needs 2 N, up to 3 N");
  assert.equal(figuresText(cell({ verdict: "beyond_force", force_largest_n: 2 })), "needs 2 N");
  assert.equal(
    bySpeed([
      { speed: 0.1, text: "7 %" },
      { speed: 0.2, text: "too weak" },
      { speed: 1, text: "too weak" },
    ]),
    "7 % at 0.1; too weak at 0.2, 1",
  );
  assert.equal(referenceText(cell({})), "reference 67\u00a0%, 78 ms");
  assert.equal(feltText(cell({ gain: 0.884 })), "88\u00a0%");
});

test("a tissue is named with all that feels like it, and with its figures", () => {
  assert.equal(tissueName(tissue(8700, ["enamel", "neighbour"])), "Enamel, neighbour");
  assert.equal(
    dampingText({ ...tissue(8700), coulomb_mn: 200, threshold_mn: 500 }),
    "B 8.7 N·s/mm, 0.2 N at any speed, cuts from 0.5 N",
  );
  assert.deepEqual(
    speedsOf(feel([cell({ speed_mm_per_s: 1 }), cell({ speed_mm_per_s: 0.1 }), cell({ speed_mm_per_s: 1 })])),
    [0.1, 1],
  );
});

test("strokes differ from 19 % of the viscosity felt, a steady cut from 7 % of its force", () => {
  const pair = (motion: FeelCell["motion"], a: number, b: number) =>
    differences(feel([cell({ motion, gain: a })]), feel([cell({ motion, gain: b })])).length;
  assert.equal(pair("strokes", 1, 0.82), 0);
  assert.equal(pair("strokes", 1, 0.8), 1);
  assert.equal(pair("strokes", 0.8, 1), 1);
  assert.equal(pair("steady", 1, 0.94), 0);
  assert.equal(pair("steady", 1, 0.92), 1);
});

test("a force only one device has is a difference, one that neither has is none", () => {
  const weak = cell({ verdict: "beyond_force" });
  assert.equal(differences(feel([weak]), feel([cell({})])).length, 1);
  assert.equal(differences(feel([cell({})]), feel([weak])).length, 1);
  assert.equal(differences(feel([weak]), feel([{ ...weak, law: { ...weak.law, gain: 0.1 } }])).length, 0);
});

test("tissues are matched by what they feel like, not by their place", () => {
  const mine = feel([cell({ tissue: 1 })], [tissue(9000), tissue(8700)]);
  const other = feel([cell({ tissue: 0, gain: 0.2 })], [tissue(8700, ["stone"])]);
  assert.equal(differences(mine, other).length, 1);
  assert.equal(comparable(mine, other), 1);
  assert.equal(comparable(mine, feel([cell({})], [tissue(1)])), 0);
});
