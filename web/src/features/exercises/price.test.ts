import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";
import { formatLimit } from "../../base/format";
import { costAt, freshPrice, kChosen, kPriced, type Price, priceOf, priceText, sizeAt, sizesText } from "./price";
import { kLeewayMm } from "./prices_table";

const spaced = (text: string) => text.replaceAll("\u00a0", " ");
const wall: Price = {
  of: "wall",
  unit: "mm",
  over: 0.45,
  left: 0.6,
  points: 12,
  most: 36,
  modify_points: 2,
  redo_points: 12,
  source: kChosen,
};

test("a price rises from nothing to its most, without a corner between", () => {
  const curve = { size: 0.45, points: 12, most: 36 };
  assert.equal(costAt(curve, 0), 0);
  assert.ok(Math.abs(costAt(curve, 0.0045) / 0.0045 - 12 / 0.45) < 0.01, "straight where it is small");
  let before = 0;
  for (let size = 0.1; size < 5; size += 0.1) {
    assert.ok(costAt(curve, size) > before, `${size}`);
    before = costAt(curve, size);
  }
  assert.ok(before < 36 && before > 34);
});

test("the size of a cost is where the curve has it, and no size costs the most", () => {
  const curve = { size: 0.6, points: 12, most: 36 };
  for (const cost of [0.5, 2, 12, 35]) assert.ok(Math.abs(costAt(curve, sizeAt(curve, cost)!) - cost) < 1e-9);
  assert.equal(sizeAt(curve, 36), undefined);
});

test("what a price says is what its curve costs", () => {
  assert.equal(
    spaced(priceText(wall)),
    "0.45 mm too far over a whole wall, or 0.60 mm left on it, costs about 12 points. It never costs more than 36.",
  );
  // The limit already bends the curve there.
  assert.match(spaced(priceText({ ...wall, most: 12 })), /costs about 8\.5 points/);
});

test("sizes of a state are said for each side, once where they agree", () => {
  assert.deepEqual(sizesText(wall, 2).map(spaced), ["0.08 mm too far", "0.10 mm left"]);
  assert.deepEqual(sizesText({ ...wall, left: 0.45 }, 2).map(spaced), ["0.08 mm too far or left"]);
  assert.deepEqual(sizesText(wall, 36), []);
  const caries: Price = { ...wall, of: "caries", unit: "%", over: null, left: 10 };
  assert.deepEqual(sizesText(caries, 2).map(spaced), ["1.7 %"]);
  const pulp: Price = { ...wall, of: "pulp", unit: "mm3", over: 0.02, left: null, points: 20, most: 50 };
  assert.deepEqual(sizesText(pulp, 2).map(spaced), ["0.002 mm³"]);
});

test("a document's price has a curve once all of its figures are above 0", () => {
  for (const kind of Object.keys(kPriced) as (keyof typeof kPriced)[]) {
    const fresh = freshPrice(kind);
    const price = priceOf(fresh);
    assert.equal(price?.of, kind);
    assert.ok(price.over !== null || price.left !== null, kind);
    assert.notEqual(priceText(price), "", kind);
    for (const bad of [null, 0, -1, "3"]) {
      for (const [member, value] of Object.entries(fresh as object)) {
        if (typeof value === "number")
          assert.equal(priceOf({ ...(fresh as object), [member]: bad }), undefined, member);
      }
    }
  }
  assert.equal(priceOf({ ...(freshPrice("wall") as object), of: "roof" }), undefined);
});

test("the leeway that the page names is the one that scores have", () => {
  const header = readFileSync("../common/scoring/mistakes/acceptable_cut.h", "utf8");
  const [, millimetres = ""] = /kLeeway_m = ([\d.]+)e-3;/.exec(header) ?? [];
  assert.equal(formatLimit(kLeewayMm, "mm"), formatLimit(Number(millimetres), "mm"));
});
