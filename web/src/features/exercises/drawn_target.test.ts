import assert from "node:assert/strict";
import { test } from "node:test";
import type { Exercise } from "../../api/types";
import { drawnTarget } from "./drawn_target";

const own: Exercise["target"] = {
  landmark: "fossa",
  tooth: 46,
  up: "occlusal" as const,
  landmark_um: [0, 0, 4000],
  half_size_um: [2000, 1500, 0],
  depth_um: 2000,
  leeway_side_um: 200,
  leeway_bottom_um: 200,
  container_um: 800,
  prepared: false,
  parts: [],
};
const typed = {
  landmark: "fossa",
  half_size_um: [1000, 900],
  depth_um: 1500,
  leeway_side_um: 0,
  leeway_bottom_um: 100,
  container_um: 700,
  prepared: false,
};

test("what is typed is drawn where the exercise's target hangs", () => {
  const drawn = drawnTarget(own, typed)!;
  assert.deepEqual(drawn.landmark_um, own.landmark_um);
  assert.deepEqual(drawn.half_size_um.slice(0, 2), [1000, 900]);
  assert.equal(drawn.depth_um, 1500);
  assert.equal(drawn.leeway_side_um, 0);
  const part = { outline: "disc", top_um: [0, 0, 0], radius_um: 500, depth_um: 500 };
  assert.deepEqual(drawnTarget(own, { ...typed, parts: [part] })?.parts, [part]);
});

test("nothing is drawn of a measure that is none, and nowhere of another landmark", () => {
  assert.equal(drawnTarget(own, undefined), undefined);
  assert.equal(drawnTarget(own, { ...typed, depth_um: null }), undefined);
  assert.equal(drawnTarget(own, { ...typed, half_size_um: [0, 900] }), undefined);
  assert.equal(drawnTarget(own, { ...typed, leeway_side_um: -1 }), undefined);
  assert.equal(drawnTarget(own, { ...typed, landmark: "apex" })?.landmark_um, null);
});
