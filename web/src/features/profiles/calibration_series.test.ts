import assert from "node:assert/strict";
import { test } from "node:test";
import { type Calibration, calibrationSeries } from "./calibration_series";

const calibration = (measuredMs: number, measured: object) =>
  ({ measured_ms: measuredMs, document: { measured } }) as unknown as Calibration;
const round = (value: number) => Math.round(value * 1e6) / 1e6;
const measure = (value: number, uncertainty = 0) => ({ value, uncertainty, samples: 100 });

test("each measured quantity is a series in the units people read, oldest first, beside the profile's number", () => {
  const series = calibrationSeries(
    [
      calibration(2000, { resolution_nm: measure(23_400, 200), friction_mn: measure(60) }),
      calibration(1000, { resolution_nm: measure(23_000, 100) }),
    ],
    new Map([["resolution", 23_000]]),
  );
  assert.deepEqual(
    series.map((one) => one.title),
    ["Resolution δ", "Friction c"],
  );
  assert.deepEqual(
    series[0]?.points.map((point) => [point.atMs, round(point.value), round(point.uncertainty)]),
    [
      [1000, 23, 0.1],
      [2000, 23.4, 0.2],
    ],
  );
  assert.equal(series[0]?.claim, 23);
  assert.equal(series[1]?.claim, undefined);
});

test("what was not measured, or is no number, is left out", () => {
  assert.deepEqual(calibrationSeries([calibration(1, {}), calibration(2, { mass_g: { value: null } })], new Map()), []);
});
