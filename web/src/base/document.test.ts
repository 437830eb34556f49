import assert from "node:assert/strict";
import { test } from "node:test";
import {
  begun,
  changed,
  changesBetween,
  equal,
  pathOf,
  pathText,
  redone,
  undone,
  valueAt,
  withValue,
} from "./document";

const kDocument = {
  title: "A",
  rubric: {
    criteria: [
      {
        metric: "wall_mesial_mm",
        points: 20,
        map: [
          [0, 1],
          [0.5, 0],
        ],
      },
      { metric: "time_s", points: 10, map: [[60, 1]] },
    ],
  },
};

test("a value is read and set at its place, and nothing else changes", () => {
  const path = ["rubric", "criteria", 1, "points"];
  assert.equal(valueAt(kDocument, path), 10);
  const after = withValue(kDocument, path, 15);
  assert.equal(valueAt(after, path), 15);
  assert.equal(valueAt(kDocument, path), 10, "the document before stays as it was");
  assert.equal(valueAt(after, ["rubric", "criteria", 0]), valueAt(kDocument, ["rubric", "criteria", 0]));
  assert.equal(valueAt(kDocument, ["rubric", "prices", 0, "most"]), undefined);
  assert.equal(pathText(path), "rubric.criteria[1].points");
});

test("a place is read however the server names it", () => {
  for (const text of ["rubric.criteria[1].points", "/rubric/criteria/1/points"])
    assert.deepEqual(pathOf(text), ["rubric", "criteria", 1, "points"]);
  assert.deepEqual(pathOf("/a~1b/c~0d"), ["a/b", "c~d"]);
  assert.deepEqual(pathOf(""), []);
});

test("an item or a member is taken away with undefined", () => {
  assert.deepEqual(valueAt(withValue(kDocument, ["rubric", "criteria", 0], undefined), ["rubric", "criteria"]), [
    kDocument.rubric.criteria[1],
  ]);
  assert.deepEqual(withValue({ a: 1, b: 2 }, ["a"], undefined), { b: 2 });
});

test("a criterion that is inserted is one change", () => {
  const [first, second] = kDocument.rubric.criteria;
  const added = { metric: "floor_mm", points: 5, map: [[0, 1]] };
  const after = { ...kDocument, rubric: { criteria: [added, first!, { ...second!, points: 12 }] } };
  assert.deepEqual(
    changesBetween(kDocument, after).map(({ path, before: was, after: now }) => [pathText(path), was, now]),
    [
      ["rubric.criteria[0]", undefined, added],
      ["rubric.criteria[2].points", 10, 12],
    ],
  );
  assert.deepEqual(
    changesBetween(after, kDocument).map(({ path }) => pathText(path)),
    ["rubric.criteria[1].points", "rubric.criteria[0]"],
  );
});

test("a list of numbers is one value, and equal documents differ in nothing", () => {
  assert.deepEqual(changesBetween(kDocument, structuredClone(kDocument)), []);
  const after = withValue(
    kDocument,
    ["rubric", "criteria", 0, "map"],
    [
      [0, 1],
      [0.4, 0],
    ],
  );
  assert.deepEqual(
    changesBetween(kDocument, after).map(({ path }) => pathText(path)),
    ["rubric.criteria[0].map"],
  );
  assert.ok(!equal({ a: 1 }, { b: 1 }));
  assert.ok(!equal([1], { 0: 1 }));
});

test("what is typed into one place is undone at once, and done again", () => {
  let history = begun(kDocument);
  for (const title of ["B", "Bo", "Box"]) history = changed(history, ["title"], title);
  history = changed(history, ["rubric", "criteria", 0], undefined);
  assert.equal(history.past.length, 2);
  history = undone(undone(history));
  assert.deepEqual(history.now, kDocument);
  assert.equal(undone(history), history, "there is nothing before the beginning");
  assert.equal(valueAt(redone(history).now, ["title"]), "Box");
  assert.deepEqual(changed(redone(history), ["title"], "C").future, [], "another change takes the undone ones away");
  assert.equal(changed(history, ["title"], "A"), history, "the same value is no step");
});
