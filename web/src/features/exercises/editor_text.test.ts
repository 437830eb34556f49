import assert from "node:assert/strict";
import { test } from "node:test";
import type { Json } from "../../base/document";
import { materialOptions, materialPrices, moreIsBetter, placeWords, rubricProblems } from "./editor_text";
import { freshPrice } from "./price";

const rubric = (points: number | null, share = 1): Json => ({
  criteria: [
    {
      title: "Mesial wall",
      points,
      map: [
        [0, share],
        [0.5, 0],
      ],
    },
    { title: "", points: 10, fails_above: 2, map: [[0, 1]] },
  ],
  prices: [freshPrice("wall"), freshPrice("caries")],
});

test("missing and out-of-range numbers of a rubric are reported in words, at their place", () => {
  assert.equal(rubricProblems(rubric(20), []).size, 0);
  assert.deepEqual(
    [...rubricProblems(rubric(-5), [])],
    [["criteria[0].points", "Enter a number from 0 to 1\u202f000."]],
  );
  assert.deepEqual(
    [...rubricProblems({ rubric: rubric(null) }, ["rubric"])],
    [["rubric.criteria[0].points", "Enter a number."]],
  );
  assert.deepEqual(
    [...rubricProblems(rubric(20, 1.4), [])],
    [["criteria[0].map[0][1]", "Enter a number from 0 to 100."]],
  );
});

test("a price without a figure above 0, or whose points do not rise, is reported at its figure", () => {
  const problems = (of: "wall" | "caries", change: Readonly<Record<string, Json>>) => [
    ...rubricProblems({ rubric: { prices: [{ ...(freshPrice(of) as object), ...change }] } }, ["rubric"]),
  ];
  const at = (member: string) => `rubric.prices[0].${member}`;
  assert.deepEqual(problems("wall", {}), []);
  assert.deepEqual(problems("wall", { over_mm: 0 }), [[at("over_mm"), "Enter a number above 0."]]);
  assert.deepEqual(problems("wall", { over_mm: 0.7, left_mm: 0.6 }), [
    [at("over_mm"), "Enter at most the 0.6 of what is left: that can still be removed."],
  ]);
  assert.deepEqual(problems("wall", { left_mm: null }), [[at("left_mm"), "Enter a number."]]);
  assert.deepEqual(problems("caries", { left_percent: -1 }), [[at("left_percent"), "Enter a number above 0."]]);
  assert.deepEqual(problems("wall", { most: 5, points: 12 }), [
    [at("most"), "Enter at least the 12 points that the sizes cost."],
  ]);
  assert.deepEqual(problems("wall", { modify_points: 10, redo_points: 10 }), [
    [at("redo_points"), "Enter more than 10, from which on a change is asked for."],
  ]);
  assert.deepEqual(problems("wall", { most: 20_000 }), [[at("most"), "Enter a number from 0 to 10\u202f000."]]);
});

test("only the named material's own prices count in place of the rubric's", () => {
  const restorations = [
    { restoration: "amalgam", prices: [{ of: "wall" }] },
    { restoration: "ceramic", prices: [] },
  ];
  assert.deepEqual([...materialPrices({ restoration: "amalgam", restorations })], ["wall"]);
  assert.deepEqual([...materialPrices({ restoration: "ceramic", restorations })], []);
  assert.deepEqual([...materialPrices({ restorations })], []);
});

test("a place is named after its content", () => {
  const document = { rubric: rubric(20) };
  assert.equal(placeWords(["rubric", "criteria", 0, "points"], document), "Rubric, Mesial wall, points");
  assert.equal(placeWords(["rubric", "criteria", 1, "fails_above"], document), "Rubric, 2, fails above");
  assert.equal(
    placeWords(["rubric", "criteria", 0, "map", 0, 1], document),
    "Rubric, Mesial wall, points kept by value, 1",
  );
  assert.equal(placeWords(["rubric", "prices", 1, "left_percent"], document), "Rubric, Caries left, left, %");
});

test("a form offers the materials that a rubric has tolerances for, and keeps one that it names", () => {
  const restorations = [{ restoration: "amalgam" }, { restoration: "ceramic" }];
  assert.deepEqual(
    materialOptions(restorations, "amalgam").map(({ value, title }) => `${value}: ${title}`),
    [": Not named", "amalgam: Amalgam", "ceramic: Ceramic"],
  );
  assert.deepEqual(
    materialOptions(undefined, "composite").map(({ value }) => value),
    ["", "composite"],
  );
  assert.equal(materialOptions(undefined, undefined).length, 1);
});

test("more is better where the shares rise over the rows", () => {
  const asDocument = (...map: readonly (readonly [number, number])[]): Json => ({ map });
  assert.equal(moreIsBetter(asDocument([80, 0], [98, 1])), true);
  assert.equal(moreIsBetter(asDocument([0.1, 1], [0.4, 0])), false);
  assert.equal(moreIsBetter(asDocument([0, 1])), false);
  assert.equal(moreIsBetter({}), false);
});
