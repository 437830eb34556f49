import { isObject } from "../base/document";
import { fail, ok, type Result } from "../base/result";

// The drawable findings of enamel-lab: the member `report` of its --json file
// (schemas/lab_report.schema.json).
export interface LabCard {
  readonly figure: string;
  readonly text: string;
  readonly good: boolean;
}

export interface LabTable {
  readonly title: string;
  readonly note: string;
  readonly head: readonly string[];
  readonly rows: readonly (readonly string[])[];
  readonly bad: readonly (readonly [number, number])[]; // row and column of cells that miss what they should hold
}

export type LabColour =
  | "1"
  | "2"
  | "3"
  | "4"
  | "5"
  | "6"
  | "7"
  | "8"
  | "reference"
  | "muted"
  | "good"
  | "bad"
  | "chosen";

export interface LabSeries {
  readonly label: string; // empty: not in the legend
  readonly colour: LabColour;
  readonly style: "line" | "dashes" | "dots" | "rings";
  readonly beside: boolean; // the label beside the last point instead of in the legend
  readonly x: readonly number[];
  readonly y: readonly number[];
}

export interface LabPlot {
  readonly title: string;
  readonly x_label: string;
  readonly y_label: string;
  readonly log_x: boolean;
  readonly log_y: boolean;
  readonly series: readonly LabSeries[];
}

export type LabVerdict = "passive" | "stable with these grips" | "bounded" | "unstable";

// A grid of verdicts on logarithmic axes with curves over it; cells row by row, x fastest.
export interface LabMap {
  readonly title: string;
  readonly x_label: string;
  readonly y_label: string;
  readonly note: string;
  readonly x: readonly number[];
  readonly y: readonly number[];
  readonly cells: readonly LabVerdict[];
  readonly curves: readonly { readonly label: string; readonly x: readonly number[]; readonly y: readonly number[] }[];
}

export interface LabSection {
  readonly title: string;
  readonly text: string;
  readonly tables: readonly LabTable[];
  readonly plots: readonly LabPlot[];
  readonly maps: readonly LabMap[];
}

export interface LabReport {
  readonly format: number;
  readonly title: string;
  readonly cards: readonly LabCard[];
  readonly sections: readonly LabSection[];
  readonly sources: readonly {
    readonly title: string;
    readonly numbers: readonly { readonly what: string; readonly source: string }[];
  }[];
}

export const kVerdicts: readonly LabVerdict[] = ["passive", "stable with these grips", "bounded", "unstable"];
const kColours: readonly string[] = [
  "1",
  "2",
  "3",
  "4",
  "5",
  "6",
  "7",
  "8",
  "reference",
  "muted",
  "good",
  "bad",
  "chosen",
];
const kStyles: readonly string[] = ["line", "dashes", "dots", "rings"];
const kFormat = 1;
const kMaxInList = 256;
const kMaxRows = 20_000;
const kMaxPoints = 4000;
const kMaxCells = 40_000;

// Finds the drawable part of a file of enamel-lab; undefined where there is none. Nothing in it is
// trusted: counts are bounded, numbers are numbers, every cell of a map has a verdict. The error
// says what was found.
export function labReportIn(report: unknown): Result<LabReport, string> | undefined {
  if (!isObject(report) || !("report" in report)) return undefined;
  const found = report["report"];
  if (!isObject(found)) return fail("the member report is no JSON object");
  if (found["format"] !== kFormat)
    return fail(`the report is of format ${String(found["format"])}, this page draws format ${kFormat}`);
  if (typeof found["title"] !== "string") return fail("the report has no title");
  const wrong =
    firstWrong(found["cards"], "card", wrongCard) ??
    firstWrong(found["sections"], "section", wrongSection) ??
    firstWrong(found["sources"], "source", wrongSource);
  return wrong === undefined ? ok(found as unknown as LabReport) : fail(wrong);
}

function firstWrong(
  list: unknown,
  what: string,
  wrongOne: (one: Record<string, unknown>) => string | undefined,
): string | undefined {
  if (!Array.isArray(list) || list.length > kMaxInList) return `expected at most ${kMaxInList} of ${what}`;
  for (const [index, one] of (list as unknown[]).entries()) {
    const wrong = isObject(one) ? wrongOne(one) : "it is no JSON object";
    if (wrong !== undefined) return `${what} ${index + 1}: ${wrong}`;
  }
  return undefined;
}

function wrongCard(card: Record<string, unknown>): string | undefined {
  return (
    wrongTexts(card, ["figure", "text"]) ??
    (typeof card["good"] === "boolean" ? undefined : "it does not say whether it is good")
  );
}

function wrongSource(source: Record<string, unknown>): string | undefined {
  return (
    wrongTexts(source, ["title"]) ??
    firstWrong(source["numbers"], "number", (one) => wrongTexts(one, ["what", "source"]))
  );
}

function wrongSection(section: Record<string, unknown>): string | undefined {
  return (
    wrongTexts(section, ["title", "text"]) ??
    firstWrong(section["tables"], "table", wrongTable) ??
    firstWrong(section["plots"], "plot", wrongPlot) ??
    firstWrong(section["maps"], "map", wrongMap)
  );
}

function wrongTable(table: Record<string, unknown>): string | undefined {
  const texts = wrongTexts(table, ["title", "note"]);
  if (texts !== undefined) return texts;
  if (!isTexts(table["head"], kMaxInList)) return "its head is no list of texts";
  const rows: unknown = table["rows"];
  if (!Array.isArray(rows) || rows.length > kMaxRows || !rows.every((row) => isTexts(row, kMaxInList)))
    return "its rows are no lists of texts";
  const bad: unknown = table["bad"];
  const isPlace = (place: unknown) => isNumbers(place, 2) && place.length === 2;
  return Array.isArray(bad) && bad.every(isPlace) ? undefined : "its bad cells are no places";
}

function wrongPlot(plot: Record<string, unknown>): string | undefined {
  const texts = wrongTexts(plot, ["title", "x_label", "y_label"]);
  if (texts !== undefined) return texts;
  if (typeof plot["log_x"] !== "boolean" || typeof plot["log_y"] !== "boolean")
    return "it does not say whether its axes are logarithmic";
  return firstWrong(plot["series"], "series", (series) => {
    if (
      !kColours.includes(series["colour"] as string) ||
      !kStyles.includes(series["style"] as string) ||
      typeof series["beside"] !== "boolean"
    ) {
      return "no colour or style that can be drawn";
    }
    const points = wrongTexts(series, ["label"]) ?? wrongPoints(series);
    if (points !== undefined) return points;
    const above = (name: string) => (series[name] as number[]).every((value) => value > 0);
    return (plot["log_x"] && !above("x")) || (plot["log_y"] && !above("y"))
      ? "0 or less on a logarithmic axis"
      : undefined;
  });
}

function wrongMap(map: Record<string, unknown>): string | undefined {
  const texts = wrongTexts(map, ["title", "x_label", "y_label", "note"]);
  if (texts !== undefined) return texts;
  const { x, y, cells } = map;
  const rises = (values: unknown) =>
    isNumbers(values, kMaxInList) &&
    values.length > 0 &&
    values.every((value, i) => value > (i > 0 ? values[i - 1]! : 0));
  if (!rises(x) || !rises(y)) return "its columns or rows are no rising numbers above 0";
  const count = (x as number[]).length * (y as number[]).length;
  if (
    !Array.isArray(cells) ||
    cells.length !== count ||
    count > kMaxCells ||
    !cells.every((cell) => (kVerdicts as readonly unknown[]).includes(cell))
  ) {
    return `expected ${count} verdicts`;
  }
  return firstWrong(map["curves"], "curve", (curve) => wrongTexts(curve, ["label"]) ?? wrongPoints(curve));
}

function wrongPoints(of: Record<string, unknown>): string | undefined {
  const { x, y } = of;
  return isNumbers(x, kMaxPoints) && isNumbers(y, kMaxPoints) && x.length === y.length
    ? undefined
    : "its points are no pairs of numbers";
}

function wrongTexts(of: Record<string, unknown>, names: readonly string[]): string | undefined {
  const name = names.find((one) => typeof of[one] !== "string");
  return name === undefined ? undefined : `its ${name} is no text`;
}

function isTexts(value: unknown, most: number): value is string[] {
  return Array.isArray(value) && value.length <= most && value.every((one) => typeof one === "string");
}

function isNumbers(value: unknown, most: number): value is number[] {
  return (
    Array.isArray(value) &&
    value.length <= most &&
    value.every((one) => typeof one === "number" && Number.isFinite(one))
  );
}
