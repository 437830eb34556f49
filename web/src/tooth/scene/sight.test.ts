import assert from "node:assert/strict";
import { test } from "node:test";
import { PerspectiveCamera, Raycaster, Vector2, Vector3 } from "three";
import { type Anatomy, fromScene, toScene } from "../../api/tooth_number";
import { sameLook } from "../../base/moment_link";
import type { AngledView } from "../messages";
import { Sight } from "./sight";

const kLowerRight: Anatomy = { mesial: -1, up: "occlusal" };
const kUpperRight: Anatomy = { mesial: 1, up: "occlusal" };
const kBuccalUp: Anatomy = { mesial: -1, up: "buccal" };
const kAngled: AngledView = { direction: [0.5, -0.6, 0.9], centre: [0, 0, 2] };
const kCavity = { centreMm: [0.5, 0.5, 3], radiusMm: 2 } as const;

function sight(anatomy: Anatomy, angled = kAngled, radius = 10): Sight {
  const made = new Sight(angled, () => undefined);
  made.setExtent({ centreMm: [1, -2, 3], radiusMm: radius });
  made.setAnatomy(anatomy);
  made.resize(640, 480);
  return made;
}

// What three makes of the same camera.
function byThree({ eye, target, up, aspect }: Sight): PerspectiveCamera {
  const camera = new PerspectiveCamera(28, aspect, 0.1, 500);
  camera.position.set(...eye);
  camera.up.set(...up);
  camera.lookAt(...target);
  camera.updateMatrixWorld();
  return camera;
}

// Where a direction of the tooth (mesial, buccal, occlusal) points in the picture: right and up.
function inPicture(seen: Sight, anatomy: Anatomy, direction: readonly [number, number, number]) {
  const camera = byThree(seen);
  const from = new Vector3(...seen.target).project(camera);
  const to = new Vector3(...seen.target).add(new Vector3(...toScene(anatomy, direction))).project(camera);
  return { right: (to.x - from.x) * camera.aspect, up: to.y - from.y };
}

test("camera and rays are those of three, from every side", () => {
  for (const anatomy of [kLowerRight, kUpperRight, kBuccalUp])
    for (const preset of ["cavity", "angled", "occlusal", "buccal", "lingual", "mesial", "distal", "apical"] as const) {
      const seen = sight(anatomy, { ...kAngled, cavity: kCavity });
      seen.view(preset);
      seen.rotate(0.3, 0.1);
      const camera = byThree(seen);
      const place = new Vector3(2, -1, 4);
      const m = seen.picture;
      const row = (i: number) => m[i]! * place.x + m[i + 4]! * place.y + m[i + 8]! * place.z + m[i + 12]!;
      const mine = new Vector3(row(0), row(1), row(2)).divideScalar(row(3));
      assert.ok(mine.distanceTo(place.clone().project(camera)) < 1e-9, preset);
      const caster = new Raycaster();
      caster.setFromCamera(new Vector2(0.4, -0.7), camera);
      assert.ok(new Vector3(...seen.wayThrough(0.4, -0.7)).normalize().distanceTo(caster.ray.direction) < 1e-9, preset);
    }
});

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
  const [x, , z] = seen.away;
  assert.ok(x < 0 && z > 0);
});

test("a section is looked at straight, and buccal stays up where it is seen from above or below", () => {
  for (const anatomy of [kLowerRight, kUpperRight, kBuccalUp])
    for (const normal of [
      [1, 0, 0],
      [0, -1, 0],
      [0, 0, 1],
      [0, 0, -1],
    ] as const) {
      const seen = sight(anatomy);
      const far = Math.hypot(...seen.away);
      seen.face(normal);
      const [x, y, z] = seen.away;
      assert.ok(Math.abs(Math.hypot(x, y, z) - far) < 1e-9, "no nearer and no farther");
      assert.ok(-(x * normal[0] + y * normal[1] + z * normal[2]) / far > 0.9999, `${normal}, ${anatomy.up} up`);
      const [, , occlusal] = fromScene(anatomy, normal);
      const up = inPicture(seen, anatomy, Math.abs(occlusal) === 1 ? [0, 1, 0] : [0, 0, 1]).up;
      assert.ok(up > 0.01, `${normal}, ${anatomy.up} up: ${up}`);
    }
});

test("panning moves what is looked at by shares of half the picture's height", () => {
  const seen = sight(kLowerRight);
  const before = byThree(seen);
  seen.pan(0.5, -0.25);
  const [x, y, z] = seen.target;
  const place = new Vector3(x, y, z).project(before);
  assert.ok(Math.abs(place.x * seen.aspect - 0.5) < 1e-9 && Math.abs(place.y + 0.25) < 1e-9);
});

test("another tooth of another size in another picture looks at the same place from the same side", () => {
  const [one, other] = [sight(kBuccalUp, { ...kAngled, cavity: kCavity }), sight(kBuccalUp, kAngled, 11)];
  other.resize(300, 480);
  one.view("cavity");
  one.rotate(0.4, 0.2);
  other.setLook(one.look());
  assert.ok(sameLook(one.look(), other.look()), JSON.stringify([one.look(), other.look()]));
});

test("a view that is asked for before it is known where the tooth is stays as it was asked for", () => {
  const [early, late] = [new Sight(kAngled, () => undefined), sight(kLowerRight)];
  const wanted = { azimuthRad: 1, polarRad: 0.5, fitsMm: 9, centreMm: [1, 2, 3] } as const;
  early.setLook(wanted);
  early.setExtent({ centreMm: [1, -2, 3], radiusMm: 10 });
  early.resize(640, 480);
  late.setLook(wanted);
  assert.ok(sameLook(early.look(), wanted), JSON.stringify(early.look()));
  assert.ok(sameLook(late.look(), wanted), JSON.stringify(late.look()));
});

test("a section begins in the middle of the cavity and reaches both ends of the tooth", () => {
  const { centreMm, radiusMm } = sight(kLowerRight, { ...kAngled, cavity: kCavity }).cutOpen;
  assert.deepEqual(centreMm, kCavity.centreMm);
  const aside = Math.hypot(0.5, 2.5, 0); // from the tooth's middle
  assert.ok(Math.abs(radiusMm - (10 + aside)) < 1e-9, String(radiusMm));
  assert.deepEqual(sight(kLowerRight).cutOpen, { centreMm: [1, -2, 3], radiusMm: 10 }, "where no cavity is known");
});

test("a view that was turned, moved and brought near is reset to what it began with", () => {
  const seen = sight(kLowerRight, { ...kAngled, cavity: kCavity });
  const begun = seen.look();
  seen.rotate(0.4, 0.2);
  seen.zoom(0.5);
  seen.follow([3, 1, 2]);
  assert.deepEqual(seen.target, [3, 1, 2], "a place that is looked at is in the middle");
  seen.reset();
  assert.ok(sameLook(seen.look(), begun), JSON.stringify(seen.look()));
});

test("the sides of a tooth that is being turned stay where they are in the picture, wherever somebody looks from", () => {
  const x = [1, 0, 0] as const;
  const y = [0, 1, 0] as const;
  const z = [0, 0, 1] as const;
  const straight: Anatomy = { ...kLowerRight, turn: [x, y, z] };
  const seen = sight(straight);
  seen.rotate(0.7, -0.2);
  const sides = (anatomy: Anatomy) => [x, y, z].map((side) => inPicture(seen, anatomy, side));
  const before = sides(straight);
  const turns: Anatomy["turn"][] = [
    [x, z, [0, -1, 0]],
    [[0.6, 0, -0.8], y, [0.8, 0, 0.6]],
  ];
  for (const turn of turns) {
    const anatomy: Anatomy = { ...straight, turn };
    seen.setAnatomy(anatomy);
    for (const [i, { right, up }] of sides(anatomy).entries())
      assert.ok(Math.hypot(right - before[i]!.right, up - before[i]!.up) < 1e-9, `side ${i}`);
    const back = fromScene(anatomy, toScene(anatomy, [0.1, 0.2, 0.3]));
    assert.ok(Math.hypot(back[0] - 0.1, back[1] - 0.2, back[2] - 0.3) < 1e-12);
  }
});
