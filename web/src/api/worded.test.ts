import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { afterEach, test } from "node:test";
import { speak } from "../base/language";
import type { MetricName, ReasonCode, Score, Unit } from "./types";
import { directionsOf, explanation, measuredText, reasonText } from "./worded";

afterEach(() => speak("en"));

const spaced = (text: string) => text.replaceAll(/[\u00a0\u202f]/g, " ");
const told = (name: MetricName, unit: Unit, code: ReasonCode, ...values: number[]) =>
  spaced(
    reasonText({
      name,
      title: "It",
      unit,
      value: values[0] ?? 0,
      points: 1,
      max_points: 2,
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
    readonly cases: readonly (Pick<Told, "title" | "unit" | "reasons" | "comment" | "under"> & {
      readonly metric: MetricName;
      readonly said: { readonly en: string };
    })[];
  };
  assert.ok(cases.length > 20);
  for (const { metric, said, ...rest } of cases)
    assert.equal(
      spaced(reasonText({ ...rest, name: metric, value: 0, points: 1, max_points: 2, reason: "as the server says" })),
      said.en,
    );
});

test("beside a table that has title and value, a reason says neither", () => {
  const explained = (code: ReasonCode, ...values: number[]) =>
    spaced(
      explanation({
        name: "wall_mesial_mm",
        title: "It",
        unit: "mm",
        value: values[0] ?? 0,
        points: 1,
        max_points: 2,
        reason: "as the server says",
        reasons: [
          { code, values, units: values.map(() => "mm" as const) },
          { code: "stop_earlier", values: [21.4, 7], units: ["s", "count"] },
        ],
        comment: "Look at it.",
      }),
    );
  const rest = "It began at 0:21.4, and stroke 7 removed most of it. Stop earlier there. Look at it.";
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
