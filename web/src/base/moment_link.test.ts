import assert from "node:assert/strict";
import { test } from "node:test";
import { momentOf, momentQuery } from "./moment_link";

const read = (text: string) => momentOf(new URLSearchParams(text));

test("a moment and a view survive the address", () => {
  const look = { azimuthRad: -1.25, polarRad: 0.8, fitsMm: 4.5, centreMm: [0, -0.5, 12.25] as const };
  assert.equal(momentQuery({ seconds: 21.4, look }), "?t=21.4&view=-1.25_0.8_4.5_0_-0.5_12.25");
  assert.deepEqual(read(momentQuery({ seconds: 21.4, look })), { seconds: 21.4, look });
  assert.equal(momentQuery({ seconds: undefined, look: undefined }), "");
});

test("what is no moment or view is left out", () => {
  for (const text of [
    "",
    "t=",
    "t=-1",
    "t=1e9",
    "t=NaN",
    "view=1_2",
    "view=a_b_c",
    "view=1_2_3",
    "view=1_2_-3_0_0_0",
    "view=99_1_1_0_0_0",
    "view=1_1_1_0_0_x",
    "view=1_1_1_0_0_501",
    "view=1_1_1_0_0_0_0",
  ])
    assert.deepEqual(read(text), { seconds: undefined, look: undefined }, text);
});
