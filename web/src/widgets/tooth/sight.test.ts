import assert from "node:assert/strict";
import { test } from "node:test";
import { Vector3 } from "three";
import { type Anatomy, toScene } from "../../api/tooth_number";
import { sameLook } from "../../base/moment_link";
import { type AngledView, Sight } from "./sight";

const kLowerRight: Anatomy = { mesial: -1, up: "occlusal" };
const kUpperRight: Anatomy = { mesial: 1, up: "occlusal" };
const kBuccalUp: Anatomy = { mesial: -1, up: "buccal" };
const kAngled: AngledView = { direction: [0.5, -0.6, 0.9], centre: [0, 0, 2] };
const kCavity = { centreMm: [0.5, 0.5, 3], radiusMm: 2 } as const;

function sight(anatomy: Anatomy, angled = kAngled, radius = 10): Sight {
  const made = new Sight(new Vector3(1, -2, 3), radius, angled, () => undefined);
  made.setAnatomy(anatomy);
  made.resize(640, 480);
  return made;
}

// Where a direction of the tooth (mesial, buccal, occlusal) points in the picture: right and up.
function inPicture({ camera, target }: Sight, anatomy: Anatomy, direction: readonly [number, number, number]) {
  camera.updateMatrixWorld();
  const from = target.clone().project(camera);
  const to = target
    .clone()
    .add(new Vector3(...toScene(anatomy, direction)))
    .project(camera);
  return { right: (to.x - from.x) * camera.aspect, up: to.y - from.y };
}

test("in every view from a side the crown is up, whichever side is up at the station", () => {
  for (const anatomy of [kLowerRight, kUpperRight, kBuccalUp])
    for (const preset of ["angled", "buccal", "lingual", "mesial", "distal"] as const) {
      const seen = sight(anatomy);
      seen.view(preset);
      const { right, up } = inPicture(seen, anatomy, [0, 0, 1]);
      assert.ok(up > 2 * Math.abs(right) - 1e-9 && up > 0, `${preset}, ${anatomy.up} up: ${right}, ${up}`);
    }
});

test("from above and below the buccal side is up, and a lower right tooth has mesial on its own side", () => {
  for (const anatomy of [kLowerRight, kUpperRight, kBuccalUp])
    for (const preset of ["occlusal", "apical"] as const) {
      const seen = sight(anatomy);
      seen.view(preset);
      assert.ok(inPicture(seen, anatomy, [0, 1, 0]).up > 0.01, `${preset}, ${anatomy.up} up`);
    }
  // Look at the patient's right cheek: the patient faces right, and mesial is towards the face.
  const seen = sight(kLowerRight);
  seen.view("buccal");
  assert.ok(inPicture(seen, kLowerRight, [1, 0, 0]).right > 0.01);
});

test("the cavity is what one sees first, until somebody turns the tooth", () => {
  const seen = sight(kLowerRight);
  seen.setAngled({ ...kAngled, cavity: kCavity });
  assert.deepEqual(seen.look().centreMm, [0.5, 0.5, 3]);
  seen.view("buccal");
  const chosen = seen.look();
  seen.setAngled({ ...kAngled, cavity: kCavity });
  assert.ok(sameLook(seen.look(), chosen));
});

test("a place is shown so near that a millimetre is a fifth of the picture's height", () => {
  const seen = sight(kLowerRight, { ...kAngled, cavity: kCavity });
  seen.near([2, 0.5, 2]);
  assert.deepEqual(seen.look().centreMm, [2, 0.5, 2]);
  const { right, up } = inPicture(seen, kLowerRight, [0, 1, 0]);
  assert.ok(Math.hypot(right, up) / 2 > 0.2, `${right}, ${up}`);
  // From where the place is met: its wall looks at the middle of the cavity.
  assert.ok(seen.away.x < 0 && seen.away.z > 0);
});

test("another tooth of another size in another picture looks at the same place from the same side", () => {
  const [one, other] = [sight(kBuccalUp, { ...kAngled, cavity: kCavity }), sight(kBuccalUp, kAngled, 11)];
  other.resize(300, 480);
  one.view("cavity");
  one.rotate(0.4, 0.2);
  other.setLook(one.look());
  assert.ok(sameLook(one.look(), other.look()), JSON.stringify([one.look(), other.look()]));
});
