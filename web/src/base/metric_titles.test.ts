import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";
import { metricTitle } from "./metric_titles";

const catalogue = JSON.parse(readFileSync("../schemas/words/en/page.json", "utf8")) as {
  readonly messages: Readonly<Record<string, string>>;
};
const titled = Object.keys(catalogue.messages)
  .filter((key) => key.startsWith("metric."))
  .map((key) => key.slice("metric.".length));

// The tables of schemas/score.md that begin "| metric | unit |": several names may share a row.
const tables = readFileSync("../schemas/score.md", "utf8")
  .split(/\n\n/)
  .filter((text) => text.startsWith("| metric | unit |"));
const metrics = tables
  .flatMap((table) => table.split("\n").slice(2))
  .flatMap((row) => {
    const [, names = "", unit = ""] = row.split("|").map((cell) => cell.trim());
    return [...names.matchAll(/`([a-z0-9_]+)`/g)].map(([, name = ""]) => ({ name, unit }));
  });

test("every measurement has a title of its own in plain words", () => {
  assert.ok(metrics.length > 60, `${metrics.length} found in schemas/score.md`);
  const titles = metrics.map(({ name, unit }) => {
    assert.ok(titled.includes(name), `${name} has no title: schemas/words/*/page.json, metric.${name}`);
    return metricTitle(name, unit);
  });
  for (const title of titles)
    assert.doesNotMatch(title, /_|\bum\b|rms|dtw|p95|percentile|zone|container|frechet|ldlj|sparc/i);
  assert.equal(new Set(titles).size, titles.length, "no two are called the same");
});

test("every title belongs to a measurement", () => {
  const names = new Set(metrics.map(({ name }) => name));
  assert.deepEqual(
    titled.filter((name) => !names.has(name)),
    [],
  );
});

test("a measurement that the page does not know is called by its name without the unit", () => {
  assert.equal(metricTitle("new_wall_mm", "mm"), "New wall");
  assert.equal(metricTitle("new_share_percent", "%"), "New share");
  assert.equal(metricTitle("new_rate_mm3_per_s", "mm3/s"), "New rate");
  assert.equal(metricTitle("new_force_n", "N"), "New force");
  assert.equal(metricTitle("new_rms_mm", "mm"), "New RMS");
});
