import assert from "node:assert/strict";
import { test } from "node:test";
import {
  burText,
  fullMarksText,
  noMarksText,
  shankText,
  timeLimitText,
  touchCuesText,
  versionText,
} from "./exercise_text";

const bur = {
  shape: "cylinder",
  radius_um: 500,
  length_um: 4000,
  narrow_radius_um: 0,
  iso_number: "",
  shank_radius_um: 0,
  neck_um: 0,
} as const;
const spaced = (text: string) => text.replaceAll("\u00a0", " ");

test("burs to change to follow the first, with their ISO numbers", () => {
  const pear = { ...bur, shape: "pear" as const, narrow_radius_um: 300, iso_number: "806 314 237 524 010" };
  assert.equal(
    spaced(burText([bur, pear])),
    "Cylinder, 1 mm across, 4 mm long; Pear, 1 mm across, 0.6 mm at the shank, 4 mm long (ISO 806 314 237 524 010)",
  );
});

test("a bur is named by its shape and what one measures of it", () => {
  assert.equal(spaced(burText([bur])), "Cylinder, 1 mm across, 4 mm long");
  assert.equal(spaced(burText([{ ...bur, shape: "sphere", length_um: 0 }])), "Round, 1 mm across");
  assert.equal(
    spaced(burText([{ ...bur, shape: "cone", narrow_radius_um: 300 }])),
    "Cone, 1 mm across, 0.6 mm at the tip, 4 mm long",
  );
  assert.equal(
    spaced(burText([{ ...bur, shape: "pear", narrow_radius_um: 300 }])),
    "Pear, 1 mm across, 0.6 mm at the shank, 4 mm long",
  );
});

test("missing parts read as none", () => {
  assert.equal(shankText(bur), "None");
  assert.equal(spaced(shankText({ ...bur, shank_radius_um: 800, neck_um: 2000 })), "1.6 mm across, neck 2 mm");
  assert.equal(timeLimitText(0), "None");
  assert.equal(timeLimitText(600), "10\u00a0min\u00a000\u00a0s");
  assert.equal(versionText({ version: 0 }), "draft");
});

test("touch cues are named with their largest force, and none where there are none", () => {
  const cues = { contact_mn: 250, chatter_mn: 100, energy_uj: 200, power_uw: 1000 } as const;
  assert.equal(touchCuesText(null), "None");
  assert.equal(
    spaced(touchCuesText(cues)),
    "Knock on contact up to 0.25 N, bur chatter up to 0.1 N. Neither affects the score",
  );
  assert.equal(spaced(touchCuesText({ ...cues, contact_mn: 0 })), "Bur chatter up to 0.1 N. Does not affect the score");
  assert.equal(
    spaced(touchCuesText({ ...cues, contact_mn: 3, chatter_mn: 0 })),
    "Knock on contact up to 3 mN. Does not affect the score",
  );
  assert.equal(
    spaced(touchCuesText({ ...cues, chatter_mn: 0 })),
    "Knock on contact up to 0.25 N. Does not affect the score",
  );
});

test("where marks begin and end is said for rising, falling and two-sided criteria", () => {
  const map = (...points: ReadonlyArray<readonly [number, number]>) =>
    points.map(([value, share]) => ({ value, share }));
  const both = (points: ReturnType<typeof map>) => [fullMarksText(points, "mm"), noMarksText(points, "mm")].map(spaced);
  assert.deepEqual(both(map([0.05, 1], [0.3, 0])), ["0.05 mm", "0.30 mm"]);
  assert.deepEqual(both(map([0, 1], [0.05, 1], [0.3, 0], [1, 0])), ["0.05 mm", "0.30 mm"]);
  assert.deepEqual(both(map([80, 0], [98, 1])), ["98.00 mm", "80.00 mm"]);
  assert.deepEqual(both(map([-0.3, 0], [-0.05, 1], [0.05, 1], [0.3, 0])), ["±0.05 mm", "beyond ±0.30 mm"]);
  assert.deepEqual(both(map([-0.2, 0], [0, 1], [0.4, 0])), ["±0.00 mm", "beyond −0.20 mm to 0.40 mm"]);
  assert.deepEqual(both([]), ["–", "–"]);
});
