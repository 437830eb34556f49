import assert from "node:assert/strict";
import { test } from "node:test";
import type { Json } from "../../base/document";
import { materialOptions, moreIsBetter, placeWords, rubricProblems } from "./editor_text";

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
  gates: [
    {
      title: "Task done",
      map: [
        [5, 0],
        [90, 1],
      ],
    },
  ],
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

test("a place is named after its content", () => {
  const document = { rubric: rubric(20) };
  assert.equal(placeWords(["rubric", "criteria", 0, "points"], document), "Rubric, Mesial wall, points");
  assert.equal(placeWords(["rubric", "criteria", 1, "fails_above"], document), "Rubric, 2, fails above");
  assert.equal(
    placeWords(["rubric", "criteria", 0, "map", 0, 1], document),
    "Rubric, Mesial wall, full and no marks, 1",
  );
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
