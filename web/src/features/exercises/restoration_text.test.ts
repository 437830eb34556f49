import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";
import { marksTexts, restorationText, sourceText } from "./restoration_text";

const spaced = (text: string) => text.replaceAll("\u00a0", " ");

test("limits of walls are beyond what the material allows, and the material names its ranges", () => {
  const undercut = {
    metric: "undercut_deg",
    unit: "deg",
    map: [
      { value: 0, share: 1 },
      { value: 6, share: 0 },
    ],
  };
  const named: Parameters<typeof restorationText>[0] = {
    name: "amalgam",
    source: "a textbook",
    divergence_deg: { mesiodistal: [-2, 10], buccolingual: [-5, 2] },
  };
  assert.deepEqual(marksTexts(undercut, named).map(spaced), ["Within its range", "6.0° beyond it"]);
  assert.deepEqual(marksTexts(undercut, null).map(spaced), ["0.0°", "6.0°"]);
  assert.deepEqual(marksTexts({ ...undercut, metric: "tilt_floor_deg" }, named).map(spaced), ["0.0°", "6.0°"]);
  assert.equal(
    spaced(restorationText(named)),
    "Amalgam: mesial and distal walls may diverge by −2.0° to 10.0°, buccal and lingual walls by −5.0° to 2.0°. Below 0, walls converge.",
  );
  assert.equal(restorationText({ ...named, divergence_deg: null }), "Amalgam");
});

test("every built-in source of limits has its words, and a school's own stays as it was typed", () => {
  const built = readFileSync("../common/scene/builtin/restorations.cpp", "utf8").replaceAll(/"\s*"/g, "");
  const composite = /"([^"]*the marginal ridge)"/.exec(built)?.[1] ?? "";
  const sources = [
    ["amalgam", /"([^"]*the ridge is thin)"/.exec(built)?.[1] ?? ""],
    ["composite", composite],
    ["composite", composite + (/"(\. Amalgam needs[^"]*)"/.exec(built)?.[1] ?? "")],
    ["ceramic", /"([^"]*half a degree)"/.exec(built)?.[1] ?? ""],
  ] as const;
  for (const [name, source] of sources) {
    const said = sourceText({ name, source });
    assert.equal(said, source.replaceAll("'", "’"));
    assert.ok(source.length > 100, source);
  }
  assert.equal(sourceText({ name: "amalgam", source: "Our own handbook" }), "Our own handbook");
});
