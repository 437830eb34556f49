import assert from "node:assert/strict";
import { test } from "node:test";
import type { MetricName } from "../../api/types";
import { toleranceMm } from "./tolerance";

const criterion = (metric: MetricName, points: readonly (readonly [number, number])[]) => ({
  metric,
  title: metric,
  unit: "mm" as const,
  points: 10,
  comment: "",
  fails_above: null,
  map: points.map(([value, share]) => ({ value, share })),
});

test("the tolerance is what the rubric gives full marks for: its strictest wall", () => {
  const walls = [
    criterion("wall_mesial_mm", [
      [-0.3, 0],
      [-0.05, 1],
      [0.05, 1],
      [0.3, 0],
    ]),
    criterion("floor_mm", [
      [-0.3, 0],
      [-0.1, 1],
      [0.1, 1],
      [0.3, 0],
    ]),
  ];
  assert.equal(toleranceMm(walls), 0.05);
  assert.equal(
    toleranceMm([
      ...walls,
      criterion("deviation_rms_mm", [
        [0.02, 1],
        [0.3, 0],
      ]),
    ]),
    0.05,
  );
});

test("without walls it is the distance's, and without that a line of the scale", () => {
  assert.equal(
    toleranceMm([
      criterion("deviation_rms_mm", [
        [0.07, 1],
        [0.3, 0],
      ]),
    ]),
    0.07,
  );
  assert.equal(
    toleranceMm([
      criterion("wall_waviness_mm", [
        [0.025, 1],
        [0.1, 0],
      ]),
    ]),
    0.1,
  );
});
