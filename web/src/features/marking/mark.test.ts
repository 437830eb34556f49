import assert from "node:assert/strict";
import { test } from "node:test";
import type { Marking, MarkingResults } from "../../api/types";
import { complete, draftFrom, filled, kNoMark, missing, nextOf, shownPoints, totalOf } from "./mark";
import { formatCoefficient, lineWithin, markedAlone, marksTable, ratedPoints } from "./results";

const kCriteria: Marking["criteria"] = [
  { name: "outline", title: "Outline", max_points: 20 },
  { name: "margins", title: "Margins", max_points: 5 },
];

test("a mark is complete with a rating and valid points for each criterion", () => {
  const begun = { ...kNoMark, points: { outline: 21, margins: 5 } };
  assert.deepEqual(
    missing(begun, kCriteria).map(({ name }) => name),
    ["outline"],
  );
  assert.equal(complete({ ...begun, rating: 3 }, kCriteria), undefined, "21 of 20");
  const whole = { rating: 3 as const, points: { outline: 12.5, margins: 5 }, comments: { outline: " too deep " } };
  assert.deepEqual(complete(whole, kCriteria), {
    rating: 3,
    criteria: { outline: { points: 12.5, comment: "too deep" }, margins: { points: 5, comment: "" } },
  });
  assert.equal(complete({ ...whole, rating: undefined }, kCriteria), undefined, "no rating");
  assert.equal(totalOf(whole, kCriteria), 70);
});

test("full marks go where nothing was entered", () => {
  assert.deepEqual(filled({ ...kNoMark, points: { outline: 3 } }, kCriteria).points, { outline: 3, margins: 5 });
});

test("full marks that are no round number are shown rounded and sent whole", () => {
  const thirds = kCriteria.map((criterion) => ({ ...criterion, max_points: 100 / 3 }));
  const draft = filled({ ...kNoMark, rating: 3 }, thirds);
  assert.deepEqual(missing(draft, thirds), []);
  assert.equal(totalOf(draft, thirds), 100);
  assert.equal(shownPoints(draft.points["outline"]), 33.33);
  assert.equal(shownPoints(Number.NaN), "");
  assert.equal(shownPoints(undefined), "");
});

test("a kept draft is read, and what is no draft is none", () => {
  assert.deepEqual(draftFrom('{"rating":9,"points":{"a":1,"b":"x"},"comments":[]}'), {
    rating: undefined,
    points: { a: 1 },
    comments: {},
  });
  for (const text of ["", "null", "{", "7"]) assert.equal(draftFrom(text).rating, undefined);
});

test("the next work is the first one after this that waits, from the beginning again", () => {
  const mine = [
    { id: "a", marked: false },
    { id: "b", marked: true },
    { id: "c", marked: false },
  ];
  assert.equal(nextOf(mine, undefined), "a");
  assert.equal(nextOf(mine, "a"), "c");
  assert.equal(nextOf(mine, "c"), "a");
  assert.equal(nextOf([{ id: "a", marked: false }], "a"), undefined);
});

const kMark = {
  total: 70,
  criteria: [{ name: "outline" as const, title: "Outline", points: 14, max_points: 20, comment: "" }],
};
const kWorks: MarkingResults["works"] = [
  {
    id: "1",
    attempt_id: "attempt",
    person: { id: "s", display_name: "Student" },
    computed_score: 64,
    marks: [
      { ...kMark, marker_id: "m", rating: 2, made_ms: 0 },
      { ...kMark, marker_id: "n", rating: 4, made_ms: 0 },
    ],
  },
];

test("every rating is a point of the plot, over the program's points or the markers' mean", () => {
  assert.deepEqual(
    ratedPoints(kWorks).map(({ rating, points }) => [rating, points]),
    [
      [2, 64],
      [4, 64],
    ],
  );
  assert.equal(ratedPoints([{ ...kWorks[0]!, computed_score: null }])[0]?.points, 70);
});

test("the line of the plot ends at 0 and 100 points", () => {
  assert.deepEqual(lineWithin(2, 60, 40, 0.6, 5.4), [0.6, 3]);
  assert.deepEqual(lineWithin(2, 60, 0, 0.6, 5.4), [0.6, 5.4]);
});

test("marks are saved as `enamel-server agreement` reads them", () => {
  const marking = {
    markers: [
      { id: "m", display_name: "Ann" },
      { id: "n", display_name: "" },
    ],
  } as never;
  const { header, rows } = marksTable(marking, { works: kWorks } as never);
  assert.deepEqual(header, ["work", "criterion", "full_marks", "marker", "mark"]);
  assert.deepEqual(rows[0], ["attempt", "Outline", 20, "Ann", 14]);
  assert.deepEqual(rows[2], ["attempt", "rating", 5, "Ann", 2]);
  assert.equal(rows[3]?.[3], "n", "somebody without a name by id");
});

test("agreement that is almost perfect is not shown as perfect", () => {
  assert.deepEqual([0.996, 0.29, 1, 0.5, -0.126].map(formatCoefficient), ["0.99", "0.29", "1", "0.5", "−0.13"]);
});

test("agreement of one marker is a sentence, of two a table", () => {
  const row = { criterion: "total", markers: ["a"], works: 3, left_out: 0, limits_of_agreement: [] };
  const alone = { ...row, why: "agreement needs a second marker" };
  const two = { ...row, markers: ["a", "b"], icc_2_1: { value: null, why: "alike" } };
  assert.equal(markedAlone([alone, { ...alone, criterion: "rating" }]), true);
  assert.equal(markedAlone([alone, two]), false);
});
