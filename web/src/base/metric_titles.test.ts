import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";
import { metricTitle } from "./format";
import { kMetricTitles } from "./metric_titles";

// {"wall_mesial_mm", "mm", "Mesial wall", …
const kEntry = /\{"([a-z0-9_]+)",\s*"([^"]*)",\s*"[^"]*",/g;
const registry = [...readFileSync("../common/scoring/registry.cpp", "utf8").matchAll(kEntry)].map(([, name = "", unit = ""]) => ({ name, unit }));

test("every measurement of the registry has a title of its own in plain words", () => {
  assert.ok(registry.length > 60, `${registry.length} found in the registry`);
  const titles = registry.map(({ name, unit }) => {
    assert.ok(Object.hasOwn(kMetricTitles, name), `${name} has no title`);
    return metricTitle(name, unit);
  });
  for (const title of titles) assert.doesNotMatch(title, /_|\bum\b|rms|dtw|p95|percentile|zone|container|frechet|ldlj|sparc/i);
  assert.equal(new Set(titles).size, titles.length, "no two are called the same");
});

test("no title is left of a measurement that is gone", () => {
  const names = new Set(registry.map(({ name }) => name));
  assert.deepEqual(Object.keys(kMetricTitles).filter((name) => !names.has(name)), []);
});
