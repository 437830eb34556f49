import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";
import type { LabSeries } from "../../api/lab_report";
import {
  edgesOf,
  kColourVariables,
  kVerdictVariables,
  mapSentence,
  plotOfMap,
  plotSentence,
  rangeOf,
  rowsOf,
  tickText,
  ticksOf,
} from "./plot_data";

const series = (x: readonly number[], y: readonly number[], label = "s"): LabSeries => ({
  label,
  colour: "1",
  style: "line",
  beside: false,
  x,
  y,
});

test("every point has a row of its own, from left to right, also where two stand above each other", () => {
  const { x, columns } = rowsOf([series([1, 3], [5, 6]), series([1, 1], [0, 1])]);
  assert.deepEqual(x, [1, 1, 1, 3]);
  assert.deepEqual(columns, [
    [5, null, null, 6],
    [null, 0, 1, null],
  ]);
});

test("cells meet half way on a logarithmic axis and reach as far beyond the ends", () => {
  assert.deepEqual(
    edgesOf([1, 4, 16]).map((edge) => Number(edge.toFixed(9))),
    [0.5, 2, 8, 32],
  );
  assert.deepEqual(edgesOf([3]), [2, 4.5]);
});

test("an axis holds all that is drawn on it, with room, and something without points", () => {
  for (const log of [false, true]) {
    const [low, high] = rangeOf([2, 50, 7], log);
    assert.ok(low < 2 && low > 0 - 1 && high > 50);
    assert.ok(rangeOf([], log)[1] > rangeOf([], log)[0]);
    assert.ok(rangeOf([3, 3], log)[1] > rangeOf([3, 3], log)[0]);
  }
  assert.equal(rangeOf([0, 10], false)[0], 0);
});

test("ticks are round, rise, lie on the axis, and are neither few nor many", () => {
  for (const [low, high, log] of [
    [0, 1, false],
    [-3.2, 117, false],
    [0.001, 0.0042, false],
    [0.5, 32, true],
    [1e-3, 1e6, true],
    [2, 9, true],
  ] as const) {
    const ticks = ticksOf(low, high, log);
    assert.ok(ticks.length >= 3 && ticks.length <= 14, `${low} to ${high}: ${ticks.length}`);
    assert.ok(
      ticks.every((tick, i) => tick >= low - 1e-9 && tick <= high * (1 + 1e-9) && (i === 0 || tick > ticks[i - 1]!)),
    );
  }
  assert.deepEqual(ticksOf(1, 1000, true), [1, 10, 100, 1000]);
  assert.equal(tickText(0.1 + 0.2), "0.3");
});

test("every colour and verdict that the schema names has a colour of the style sheet", () => {
  const schema = JSON.parse(readFileSync("../schemas/lab_report.schema.json", "utf8"));
  const style = readFileSync("src/app/base.css", "utf8");
  const variables: Readonly<Record<string, string>> = { ...kColourVariables, ...kVerdictVariables };
  for (const name of [...schema.$defs.series.properties.colour.enum, ...schema.$defs.map.properties.cells.items.enum]) {
    assert.ok(style.includes(`${variables[name]}:`), `${name}: ${variables[name]}`);
  }
});

test("a picture has a sentence: its axes, and the number of cells of each kind", () => {
  const map = {
    title: "Map",
    x_label: "B",
    y_label: "delay",
    note: "",
    x: [1, 2],
    y: [1],
    cells: ["passive", "unstable"] as const,
    curves: [{ label: "theory", x: [1], y: [1] }],
  };
  assert.equal(mapSentence(map), "Map. delay against B: 1 passive, 1 unstable");
  assert.equal(plotSentence(plotOfMap(map)), "Map. delay against B: theory");
});
