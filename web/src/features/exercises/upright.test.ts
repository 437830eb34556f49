import assert from "node:assert/strict";
import { test } from "node:test";
import { toScene } from "../../api/tooth_number";
import { axesIn, directionOf, directionText, turnedAbout, type Upright } from "./upright";

const kAxes = ["mesial", "buccal", "occlusal"] as const;
const kStraight: Upright = { up: [0, 0, 1], buccal: [0, 1, 0] };
const kSlanted: Upright = { up: [0.6, 0, 0.8], buccal: [0, 1, 0] };

function near(found: readonly number[], expected: readonly number[]) {
  for (const [i, value] of found.entries())
    assert.ok(Math.abs(value - expected[i]!) < 1e-12, `${found} and not ${expected}`);
}

test("four quarter turns and 72 of 5 degrees end where they began, and keep their own axis", () => {
  for (const axis of kAxes)
    for (const [degrees, times] of [
      [90, 4],
      [-90, 4],
      [5, 72],
    ] as const) {
      let now = kSlanted;
      for (let i = 0; i < times; ++i) {
        now = turnedAbout(now, -1, axis, degrees);
        near(directionOf(now, -1, axis), directionOf(kSlanted, -1, axis));
      }
      near([...now.up, ...now.buccal], [...kSlanted.up, ...kSlanted.buccal]);
    }
});

test("mesial is buccal times occlusal at the right of the upper jaw and the left of the lower one, else against it", () => {
  near(directionOf(kStraight, 1, "mesial"), [1, 0, 0]);
  near(directionOf(kStraight, -1, "mesial"), [-1, 0, 0]);
});

test("a turn about the occlusal axis goes counter-clockwise from above on either side of the mouth", () => {
  // What lay at +x comes to +y, the buccal side.
  const right = turnedAbout(kStraight, 1, "occlusal", 90);
  near(right.buccal, directionOf(kStraight, 1, "mesial"));
  const left = turnedAbout(kStraight, -1, "occlusal", 90);
  near(left.buccal, [1, 0, 0]);
});

test("a tooth that lies on its buccal side in the file stands after a quarter turn", () => {
  // Occlusal is +y of the file, and the import took +z.
  const now = turnedAbout(kStraight, 1, "mesial", 90);
  near(now.up, [0, 1, 0]);
  near(now.buccal, [0, 0, -1]);
  assert.equal(directionText(now.up), "0,1,0");
  // In the picture of what was imported the new occlusal is +y too.
  const anatomy = { mesial: 1, up: "occlusal", turn: axesIn(kStraight, now) } as const;
  near(toScene(anatomy, [0, 0, 1]), [0, 1, 0]);
  near(toScene(anatomy, [1, 0, 0]), [1, 0, 0]);
});

test("turns about different axes compose in the order in which they were made", () => {
  const now = turnedAbout(turnedAbout(kSlanted, 1, "occlusal", 90), 1, "buccal", 90);
  const axes = axesIn(kSlanted, now);
  // Rz(-90) Ry(-90) in the tooth's own axes: x to y, y to z, z to x.
  near(axes[0], [0, 0, 1]);
  near(axes[1], [1, 0, 0]);
  near(axes[2], [0, 1, 0]);
});
