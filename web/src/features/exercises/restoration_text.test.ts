import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";
import { sourceText } from "./restoration_text";

test("every built-in source of limits has its words, and a school's own stays as it was typed", () => {
  const built = readFileSync("../common/scene/builtin/restorations.cpp", "utf8").replaceAll(/"\s*"/g, "");
  const composite = /"([^"]*diverge; the sizes are chosen)"/.exec(built)?.[1] ?? "";
  const sources = [
    ["amalgam", /"([^"]*own prices count)"/.exec(built)?.[1] ?? ""],
    ["composite", composite],
    ["composite", composite + (/"(\. Amalgam needs[^"]*)"/.exec(built)?.[1] ?? "")],
    ["ceramic", /"([^"]*seat; the sizes are chosen)"/.exec(built)?.[1] ?? ""],
  ] as const;
  for (const [name, source] of sources) {
    const said = sourceText({ name, source });
    assert.equal(said, source.replaceAll("'", "’"));
    assert.ok(source.length > 100, source);
  }
  assert.equal(sourceText({ name: "amalgam", source: "Our own handbook" }), "Our own handbook");
});
