import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";
import { drawableIn, titleOf } from "./drawable";
import { labReportIn } from "./lab_report";

const kGolden = readFileSync("../schemas/golden/lab_report.json", "utf8");
interface Loose {
  [name: string]: Loose;
  [index: number]: Loose;
}
const golden = () => JSON.parse(kGolden) as { report: Loose };

function said(document: unknown): string {
  const found = labReportIn(document);
  return found === undefined ? "nothing" : found.ok ? "read" : found.error;
}

test("the golden document is read, and what has no member report holds none", () => {
  assert.equal(said(golden()), "read");
  for (const other of [null, 1, [], {}, { rows: [] }]) assert.equal(said(other), "nothing");
});

test("a report that cannot be drawn is refused with what was found", () => {
  const broken: readonly (readonly [(report: Loose) => void, RegExp])[] = [
    [
      (report) => {
        Object.assign(report, { format: 9 });
      },
      /format 9, this page draws format 1/,
    ],
    [
      (report) => {
        Object.assign(report, { title: 7 });
      },
      /no title/,
    ],
    [
      (report) => {
        Object.assign(report, { cards: {} });
      },
      /at most 256 of card/,
    ],
    [
      (report) => {
        Object.assign(report["cards"]![0]!, { good: "yes" });
      },
      /card 1: it does not say whether it is good/,
    ],
    [
      (report) => {
        Object.assign(report, { sections: [1] });
      },
      /section 1: it is no JSON object/,
    ],
    [
      (report) => {
        Object.assign(plotOf(report), { log_x: 1 });
      },
      /plot 1: it does not say/,
    ],
    [
      (report) => {
        Object.assign(plotOf(report)["series"]![0]!, { colour: "red" });
      },
      /no colour or style/,
    ],
    [
      (report) => {
        Object.assign(plotOf(report)["series"]![0]!, { x: [1] });
      },
      /no pairs of numbers/,
    ],
    [
      (report) => {
        Object.assign(plotOf(report), { log_y: true });
        Object.assign(plotOf(report)["series"]![0]!, { x: [1], y: [0] });
      },
      /0 or less/,
    ],
    [
      (report) => {
        Object.assign(mapOf(report), { cells: ["passive"] });
      },
      /expected 4 verdicts/,
    ],
    [
      (report) => {
        Object.assign(mapOf(report), { x: [2, 1] });
      },
      /no rising numbers/,
    ],
    [
      (report) => {
        Object.assign(tableOf(report), { rows: [["a", 1]] });
      },
      /its rows are no lists of texts/,
    ],
    [
      (report) => {
        Object.assign(tableOf(report), { bad: [[0]] });
      },
      /no places/,
    ],
  ];
  for (const [change, why] of broken) {
    const document = golden();
    change(document.report);
    assert.match(said(document), why);
  }
});

test("strokes and a report are drawn together, and a broken part is not passed over", () => {
  const strokes = JSON.parse(readFileSync("../schemas/golden/strokes.json", "utf8")) as { format: number };
  const both = drawableIn({ ...golden(), strokes });
  assert.ok(both.ok && both.value.report !== undefined && both.value.strokes !== undefined);
  const alone = drawableIn(strokes);
  assert.ok(alone.ok && alone.value.report === undefined);
  assert.match(titleOf(both.value), /^Qualification: /);
  assert.deepEqual(drawableIn({ ...golden(), strokes: { ...strokes, format: 99 } }).ok, false);
  assert.deepEqual(drawableIn({ report: { format: 2 }, strokes }).ok, false);
  // What was drawn is such a document itself.
  assert.ok(drawableIn(both.value).ok);
});

function sectionWith(report: Loose, what: string): Loose {
  const sections = report["sections"] as unknown as Loose[];
  return sections.find((section) => (section[what] as unknown as unknown[]).length > 0)!;
}
const plotOf = (report: Loose) => sectionWith(report, "plots")["plots"]![0]!;
const mapOf = (report: Loose) => sectionWith(report, "maps")["maps"]![0]!;
const tableOf = (report: Loose) => sectionWith(report, "tables")["tables"]![0]!;
