import assert from "node:assert/strict";
import { test } from "node:test";
import { allOf, covering } from "./covering.mjs";

const kFactors = {
  width: [360, 768, 1280, 3840],
  language: ["en", "de", "zh"],
  theme: ["light", "dark", "contrast"],
  zoom: [1, 2],
};
const fits = ({ width, zoom }) => width / zoom >= 320;

test("all are the product without what cannot be", () => {
  assert.equal(allOf(kFactors).length, 72);
  assert.equal(allOf(kFactors, fits).length, 63);
});

test("every pair of values occurs, and every page meets every value", () => {
  const pages = ["a", "b", "c", "d"];
  const { combinations, left } = covering(pages, kFactors, { each: 4, fits });
  assert.deepEqual(left, []);
  assert.equal(combinations.length, 16);
  for (const page of pages)
    for (const [name, values] of Object.entries(kFactors))
      assert.deepEqual(
        new Set(combinations.filter((one) => one.page === page).map((one) => one[name])),
        new Set(values),
        `${page} meets every ${name}`,
      );
  assert.ok(combinations.every(fits));
});
