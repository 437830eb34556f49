import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";
import { strokesIn, type StrokeCase } from "../../api/strokes";
import { caseSentence, caseText, drawn, figureText, figureTitle, joined, kIdealLine } from "./tracks";

function golden(): readonly StrokeCase[] {
  const found = strokesIn(JSON.parse(readFileSync("../schemas/golden/strokes.json", "utf8")));
  assert.ok(found.ok);
  return found.value.devices[0]!.cases;
}

test("columns of different times are joined over all of them, with gaps", () => {
  assert.deepEqual(
    joined([
      { timeS: [0, 2], values: [5, 6] },
      { timeS: [0, 1], values: [7, 8] },
    ]),
    {
      timeS: [0, 1, 2],
      columns: [
        [5, null, 6],
        [7, 8, null],
      ],
    },
  );
});

test("the law in use is drawn last, the ideal is its own, and every point is there", () => {
  for (const one of golden()) {
    const { lines, data } = drawn(one);
    assert.equal(lines.length, data.columns.length);
    assert.equal(lines.at(-1)!.label, `${one.tracks[0]!.law}, the law in use`);
    assert.deepEqual(
      data.columns.at(-1)!.filter((value) => value !== null),
      one.tracks[0]!.force_n,
    );
    assert.deepEqual(
      data.columns[lines.indexOf(kIdealLine)]!.filter((value) => value !== null),
      one.tracks[0]!.ideal_n,
    );
  }
});

test("every case and figure of the schema has words", () => {
  const schema = JSON.parse(readFileSync("../schemas/strokes.schema.json", "utf8"));
  for (const name of schema.$defs.case.properties.name.enum) assert.notEqual(caseText(name).look, "", name);
  for (const name of schema.$defs.figure.properties.name.enum) assert.notEqual(figureTitle(name), name);
  assert.equal(figureText(0.0972, "s"), "97 ms");
  assert.equal(figureText(0.15, "N"), "0.15 N");
  assert.equal(figureText(1.266, ""), "1.27");
});

test("the sentence says the forces, and what is not held", () => {
  const one = golden()[0]!;
  const track = one.tracks[0]!;
  assert.match(
    caseSentence({ ...one, tracks: [{ ...track, figures: [] }] }),
    /Every judged figure is within its limit/,
  );
  const missed = { name: "pull_n", unit: "N", value: 1, bound: 0.15, held: false };
  assert.match(
    caseSentence({ ...one, tracks: [{ ...track, figures: [missed] }] }),
    /Outside the limit: Pull against the hand in air\./,
  );
});
