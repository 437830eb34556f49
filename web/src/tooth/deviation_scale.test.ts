import assert from "node:assert/strict";
import { test } from "node:test";
import { deviationColor, deviationScalePixels, kUntouchedColor, parseHex } from "./deviation_scale";

test("a deviation of zero is a pale, quiet middle, and both ends are the end colours", () => {
  assert.deepEqual(deviationColor(-0.5), parseHex("#053061"));
  assert.deepEqual(deviationColor(0.5), parseHex("#67001f"));
  const spread = (mm: number) => Math.max(...deviationColor(mm)) - Math.min(...deviationColor(mm));
  assert.ok(
    deviationColor(0).every((value) => value > 220),
    "light",
  );
  for (const mm of [-0.2, 0.2]) assert.ok(spread(0) < spread(mm) / 3, "right places stand out less than wrong ones");
});

test("beyond the range the colour stays at the end", () => {
  assert.deepEqual(deviationColor(3), deviationColor(0.5));
  assert.deepEqual(deviationColor(-3), deviationColor(-0.5));
});

test("untouched is neutral and differs from every colour of the scale", () => {
  assert.deepEqual(deviationColor(Number.NaN), parseHex(kUntouchedColor));
  for (let mm = -0.5; mm <= 0.5; mm += 0.01) {
    const distance = Math.hypot(...deviationColor(mm).map((value, i) => value - parseHex(kUntouchedColor)[i]!));
    assert.ok(distance > 40, `${mm} mm is ${distance} from untouched`);
  }
});

test("more removed is red over blue and less removed is blue over red", () => {
  for (const mm of [0.1, 0.2, 0.3, 0.4]) {
    const more = deviationColor(mm);
    const less = deviationColor(-mm);
    assert.ok(more[0] > more[2]);
    assert.ok(less[2] > less[0]);
  }
});

test("the pixels run from least to most removed", () => {
  const pixels = deviationScalePixels(11);
  assert.deepEqual([...pixels.slice(0, 3)], [...deviationColor(-0.5)]);
  assert.deepEqual([...pixels.slice(40, 43)], [...deviationColor(0.5)]);
});
