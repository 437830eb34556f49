import assert from "node:assert/strict";
import { test } from "node:test";
import { golden, isDentin, value } from "./golden.test";
import { decodeInterior, tissueAt, tissuesIn } from "./interior";

const kVoxelMm = 0.1;
const kOriginMm = -1.95;
const placeOf = (sample: number) => kOriginMm + kVoxelMm * sample;

test("inside the golden ball each place has the tissue that the document says", async () => {
  const interior = value(await decodeInterior(golden("entb")));
  assert.deepEqual(tissuesIn(interior), [1, 2]);
  for (const [x, y, z] of [
    [19, 19, 19],
    [20, 12, 19],
    [28, 19, 22],
    [30, 19, 19],
    [19, 8, 19],
  ] as const)
    assert.equal(tissueAt(interior, placeOf(x), placeOf(y), placeOf(z)), isDentin(x, y, z) ? 2 : 1, `${x}, ${y}, ${z}`);
});

test("far from the ball and outside the grid there is air", async () => {
  const interior = value(await decodeInterior(golden("entb")));
  assert.equal(tissueAt(interior, 40, 0, 0), 0);
  assert.equal(tissueAt(interior, 0, 0, -40), 0);
});

test("a start tooth that is damaged, cut short or of another kind is refused", async () => {
  const whole = golden("entb");
  const error = async (bytes: ArrayBuffer) => {
    const read = await decodeInterior(bytes);
    return read.ok ? "" : read.error;
  };
  assert.match(await error(whole.slice(0, 20)), /expected more than 20 bytes/);
  assert.match(await error(whole.slice(0, whole.byteLength - 1)), /ends early/);
  assert.match(await error(golden("entl")), /begins with ENTS/);
  const damaged = whole.slice(0);
  new Uint8Array(damaged)[60]! ^= 255;
  assert.notEqual(await error(damaged), "");
});
