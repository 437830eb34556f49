import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { afterEach, test } from "node:test";
import { speak } from "../base/language";
import type { MetricName, Mistake, ReasonCode, Score, Unit } from "./types";
import {
  borderlineText,
  criterionTitle,
  directionsOf,
  explanation,
  measuredText,
  mistakeText,
  placeText,
  reasonText,
  regionText,
  regionTitle,
  remedyText,
} from "./worded";

afterEach(() => speak("en"));

const spaced = (text: string) => text.replaceAll(/[\u00a0\u202f]/g, " ");
const told = (name: MetricName, unit: Unit, code: ReasonCode, ...values: number[]) =>
  spaced(
    reasonText({
      name,
      title: "It",
      unit,
      reason: "as the server says",
      reasons: [{ code, values, units: values.map(() => unit) }],
    }),
  );

test("a signed measurement says which way, and no other does", () => {
  const documented = [...readFileSync("../schemas/score.md", "utf8").matchAll(/`([a-z0-9_]+)`/g)].map(
    ([, name = ""]) => name,
  );
  const signed = [
    "wall_mesial_mm",
    "wall_distal_mm",
    "wall_buccal_mm",
    "wall_lingual_mm",
    "floor_mm",
    "tilt_mesial_deg",
    "tilt_distal_deg",
    "tilt_buccal_deg",
    "tilt_lingual_deg",
    "divergence_mesial_deg",
    "divergence_distal_deg",
    "divergence_buccal_deg",
    "divergence_lingual_deg",
    "finish_depth_mm",
  ];
  assert.deepEqual([...new Set(documented.filter((name) => directionsOf(name) !== undefined))].sort(), signed.sort());
  assert.equal(spaced(measuredText("floor_mm", 0.22, "mm")), "0.22 mm too deep");
  assert.equal(spaced(measuredText("finish_depth_mm", -2.98, "mm")), "2.98 mm too high");
  assert.equal(spaced(measuredText("wall_mesial_mm", -0.1, "mm")), "0.10 mm short");
  assert.equal(spaced(measuredText("wall_mesial_mm", -0.001, "mm")), "0.00 mm off");
  assert.equal(spaced(measuredText("tilt_buccal_deg", -3, "deg")), "3.0° undercut");
  assert.equal(spaced(measuredText("divergence_lingual_deg", -4, "deg")), "4.0° undercut");
  assert.equal(spaced(measuredText("tilt_floor_deg", 3, "deg")), "3.0°");
  assert.equal(spaced(measuredText("convergence_least_deg", -2, "deg")), "−2.0°");
});

test("reasons read as the server's do: schemas/score.md", () => {
  assert.equal(
    told("deviation_rms_mm", "mm", "at_most", 0.2, 0.1, 0.3),
    "It: 0.20 mm (full marks up to 0.10 mm, none from 0.30 mm).",
  );
  assert.equal(
    told("task_done_percent", "%", "at_least", 80, 97, 70),
    "It: 80.0 % (full marks from 97.0 %, none up to 70.0 %).",
  );
  assert.equal(
    told("wall_mesial_mm", "mm", "within", 0.12, 0.03, 0.25),
    "It: 0.12 mm too deep (full marks within 0.03 mm, none beyond 0.25 mm).",
  );
  assert.equal(told("floor_mm", "mm", "within", -0.12, 0.03), "It: 0.12 mm too shallow (full marks within 0.03 mm).");
  assert.equal(
    told("finish_width_mm", "mm", "between", 0.4, 0.2, 0.3),
    "It: 0.40 mm (full marks from 0.20 mm to 0.30 mm).",
  );
  assert.equal(
    told("pulp_exposed_mm2", "mm2", "fails_above", 0.3, 0),
    "It: 0.30 mm² (more than 0.00 mm² fails the whole attempt).",
  );
  assert.equal(told("pulp_exposed_mm2", "mm2", "at_most", 0.3, 0), "It: 0.30 mm² (full marks at 0.00 mm²).");
  assert.equal(told("pulp_exposed_mm2", "mm2", "not_in_task"), "It: not judged, because the reference has none of it.");
  assert.equal(told("pulp_exposed_mm2", "mm2", "something_new" as ReasonCode, 1), "as the server says");
});

// The station's test reads the same file (tests/station/desk/score_words_test.cpp), in all
// languages; here English is there.
test("the page and the station's window make the same sentences", () => {
  type Told = Score["criteria"][number];
  const { cases } = JSON.parse(readFileSync("../schemas/golden/reasons_said.json", "utf8")) as {
    readonly cases: readonly (Pick<Told, "title" | "unit" | "reasons" | "comment"> & {
      readonly metric: MetricName;
      readonly said: { readonly en: string };
    })[];
  };
  assert.ok(cases.length > 20);
  for (const { metric, said, ...rest } of cases)
    assert.equal(spaced(reasonText({ ...rest, name: metric, reason: "as the server says" })), said.en);
});

test("beside a table that has title and value, a reason says neither", () => {
  const explained = (code: ReasonCode, ...values: number[]) =>
    spaced(
      explanation({
        name: "wall_mesial_mm",
        title: "It",
        unit: "mm",
        reason: "as the server says",
        reasons: [
          { code, values, units: values.map(() => "mm" as const) },
          { code: "do_lighter", values: [], units: [] },
        ],
        comment: "Look at it.",
      }),
    );
  const rest = "Press less and let the bur cut. Look at it.";
  assert.equal(explained("within", 0.12, 0.03, 0.25), `Full marks within 0.03 mm, none beyond 0.25 mm. ${rest}`);
  assert.equal(explained("any", 0.12), rest);
  assert.equal(explained("something_new" as ReasonCode, 1), "as the server says");
});

test("a value that misses its limit does not read like it, and a limit is not rounded", () => {
  assert.equal(told("deviation_rms_mm", "mm", "at_most", 0.1004, 0.1), "It: 0.1004 mm (full marks up to 0.10 mm).");
  assert.equal(told("deviation_rms_mm", "mm", "at_most", 0.0999, 0.1), "It: 0.10 mm (full marks up to 0.10 mm).");
  assert.equal(
    told("deviation_rms_mm", "mm", "at_most", 0.4998, 0.1, 0.5),
    "It: 0.50 mm (full marks up to 0.10 mm, none from 0.50 mm).",
  );
  assert.equal(told("deviation_rms_mm", "mm", "at_most", 0.0253, 0.025), "It: 0.03 mm (full marks up to 0.025 mm).");
  assert.equal(told("deviation_rms_mm", "mm", "at_most", 0.028, 0.0285), "It: 0.028 mm (full marks up to 0.0285 mm).");
  assert.equal(told("deviation_rms_mm", "mm", "at_most", 0.2, 0.025), "It: 0.20 mm (full marks up to 0.025 mm).");
});

test("a time and a rate have the form that they have everywhere on the page", () => {
  assert.equal(
    told("time_s", "s", "at_most", 1438.1, 600, 900),
    "It: 23 min 58 s (full marks up to 10 min 00 s, none from 15 min 00 s).",
  );
  assert.equal(told("time_s", "s", "any", 86.9), "It: 1 min 27 s.");
  assert.equal(
    told("enamel_rate_mm3_per_s", "mm3/s", "at_most", 1.5, 1),
    "It: 1.50 mm³/s (full marks up to 1.00 mm³/s).",
  );
});

test("a mistake says where, what and how much, as finely as people act on it", () => {
  const said = (kind: Mistake["kind"], place: string, size: number, unit: Unit) =>
    spaced(mistakeText({ kind, place, size, unit }));
  assert.equal(said("over_extended", "wall_distal", 0.3248, "mm"), "Distal wall: over-extended by 0.32 mm");
  assert.equal(said("turned", "", 7.96, "deg"), "Preparation turned by 8.0°");
  assert.equal(said("caries", "", 33.4, "%"), "33 % of the caries left");
  assert.equal(said("not_done", "", 0.25, "%"), "0.3 % of the task not done", "not 0 %");
  assert.equal(said("hole", "", 1.4, "mm3"), "Hole outside the task: 1.40 mm³");
  assert.equal(said("uneven", "floor_2", 0, "mm"), "Lower floor: uneven");
  assert.equal(said("burnt" as Mistake["kind"], "wall_roof", 0.3, "mm"), "Wall roof Burnt 0.30 mm", "a newer server's");
  assert.equal(remedyText({ kind: "burnt" as Mistake["kind"] }), "");
});

// As the contract and the core have them: a kind or a region without words would show its code.
test("every kind of mistake, group, state and price, and every name of a region, has words", () => {
  const contract = readFileSync("../schemas/api/openapi.yaml", "utf8");
  const namesOf = (schema: string) => {
    const [, list = ""] =
      new RegExp(`\\n {4}${schema}:\\n(?: {6}.*\\n)*? {6}enum:\\s*\\[([^\\]]*)\\]`).exec(contract) ?? [];
    return list.split(/[,\s]+/).filter((name) => name !== "");
  };
  const messages = (
    JSON.parse(readFileSync("../schemas/words/en/exercise.json", "utf8")) as {
      readonly messages: Readonly<Record<string, string>>;
    }
  ).messages;
  const told = (prefix: string) =>
    Object.keys(messages)
      .filter((key) => key.startsWith(`${prefix}.`))
      .map((key) => key.slice(prefix.length + 1));
  const kinds = namesOf("MistakeKind");
  assert.ok(kinds.length > 20, `${kinds.length} kinds`);
  assert.deepEqual(told("mistake"), [...kinds].sort());
  assert.deepEqual(told("mistake_do"), [...kinds].sort());
  assert.deepEqual(told("group"), namesOf("GradeGroup").sort());
  assert.deepEqual(told("grade_state"), namesOf("GradeState").sort());
  assert.deepEqual(told("price_kind"), namesOf("PriceKind").sort());

  const core = readFileSync("../common/scoring/mistakes/cut_surface.cpp", "utf8");
  const literals = [...core.matchAll(/"((?:wall|axial|cusp|margin|face|floor|line)_?[a-z_]*)"/g)].map(
    ([, name = ""]) => name,
  );
  assert.ok(literals.length > 10, `${literals.length} names`);
  const places = told("place");
  for (const name of literals)
    assert.ok(
      places.some((place) => (name.endsWith("_") ? place.startsWith(name) : place === name || place.startsWith(name))),
      name,
    );
});

test("a region has a name, and says how far its dearer side is off", () => {
  const wall = { dearer: "over", over: 0.32, left: 0.1, unit: "mm" } as const;
  assert.equal(spaced(regionText(wall)), "0.32 mm too much");
  assert.equal(spaced(regionText({ ...wall, dearer: "left" })), "0.10 mm left");
  assert.equal(regionText({ ...wall, over: 0 }), "");
  assert.equal(regionTitle({ name: "cusp_mesiobuccal", kind: "table" }), "Mesiobuccal cusp");
  assert.equal(regionTitle({ name: "neighbour", kind: "neighbour" }), "Adjacent tooth");
  assert.equal(placeText(""), "");
});

test("a group has the page's name, a figure of the hand the rubric's", () => {
  assert.equal(criterionTitle({ name: "internal_form", title: "Internal shape" }), "Internal form");
  assert.equal(criterionTitle({ name: "time_s", title: "As fast as in the clinic" }), "As fast as in the clinic");
});

test("a borderline limit says value, limit and uncertainty", () => {
  const limit = { name: "neighbour_depth_mm", unit: "mm", above: true, reason: "" } as const;
  const said = borderlineText({ ...limit, error: "neighbour_damaged", value: 0.27, limit: 0.25, uncertainty: 0.029 });
  assert.equal(
    spaced(said),
    "Borderline: “The adjacent tooth is damaged” is not certain (0.27 mm, limit 0.25 mm, standard uncertainty 0.03 mm).",
  );
  const points = borderlineText({
    ...limit,
    error: "points",
    name: "points",
    unit: "",
    value: 50.6,
    limit: 50,
    uncertainty: 0.4,
  });
  assert.match(spaced(points), /\(50\.6, limit 50, standard uncertainty 0\.4\)\.$/);
});
