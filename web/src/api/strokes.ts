import { isObject } from "../base/document";
import { fail, ok, type Result } from "../base/result";

// Six short motions of a hand on a device, as `enamel-lab qualify --suite withdrawal` writes them
// (schemas/strokes.schema.json).
export interface StrokeFigure {
  readonly name: string;
  readonly unit: string;
  readonly value: number;
  readonly bound: number | null; // null: told, not judged
  readonly held: boolean;
}

export interface StrokeTrack {
  readonly law: string;
  readonly default: boolean;
  readonly held: boolean;
  readonly ticks: number;
  readonly leaves_s: number | null; // when the ideal bur leaves the tissue for good
  readonly figures: readonly StrokeFigure[];
  readonly t_s: readonly number[];
  readonly force_n: readonly number[]; // against the hand's motion; below 0: along with it
  readonly magnitude_n: readonly number[];
  readonly ideal_n: readonly number[];
  readonly oracle_n: readonly number[];
  readonly tip_mm: readonly number[];
  readonly bur_mm: readonly number[];
}

export interface StrokeCase {
  readonly name: string;
  readonly tracks: readonly StrokeTrack[]; // the default law first
}

export interface StrokeDevice {
  readonly name: string;
  readonly title: string;
  readonly rate_hz: number;
  readonly delay_ticks: number;
  readonly kc_n_per_mm: number;
  readonly resolution_um: number;
  readonly peak_force_n: number;
  readonly continuous_force_n: number;
  readonly cases: readonly StrokeCase[];
}

export interface Strokes {
  readonly format: number;
  readonly core_version: number;
  readonly b_n_s_per_mm: number;
  readonly devices: readonly StrokeDevice[];
}

const kFormat = 1;
const kMaxPoints = 2000;
const kMaxDevices = 32;
const kMaxCases = 32;
const kMaxTracks = 8;
const kMaxFigures = 32;
const kColumns = ["t_s", "force_n", "magnitude_n", "ideal_n", "oracle_n", "tip_mm", "bur_mm"] as const;
const kDeviceNumbers = [
  "rate_hz",
  "delay_ticks",
  "kc_n_per_mm",
  "resolution_um",
  "peak_force_n",
  "continuous_force_n",
] as const;

// Finds the strokes in a report: the document itself, or the member `strokes` of what `qualify`
// wrote. Nothing in it is trusted: counts are bounded, numbers are numbers, time grows. The error
// says what was found.
export function strokesIn(report: unknown): Result<Strokes, string> {
  if (!isObject(report)) return fail("the report is no JSON object");
  const document = "strokes" in report ? report["strokes"] : report;
  if (!isObject(document) || !Array.isArray(document["devices"])) {
    return fail("the report holds no strokes");
  }
  if (document["format"] !== kFormat)
    return fail(`the strokes are of format ${String(document["format"])}, this page draws format ${kFormat}`);
  if (!isNumber(document["b_n_s_per_mm"])) return fail("b_n_s_per_mm is no number");
  const devices: unknown[] = document["devices"];
  if (devices.length === 0 || devices.length > kMaxDevices)
    return fail(`expected 1 to ${kMaxDevices} devices, found ${devices.length}`);
  for (const device of devices) {
    const wrong = wrongDevice(device);
    if (wrong !== undefined) return fail(wrong);
  }
  return ok(document as unknown as Strokes);
}

function wrongDevice(device: unknown): string | undefined {
  if (!isObject(device) || !isText(device["name"]) || !isText(device["title"]))
    return "a device has no name or no title";
  const where = `device ${device["name"]}`;
  for (const name of kDeviceNumbers) if (!isNumber(device[name])) return `${where}: ${name} is no number`;
  const cases: unknown = device["cases"];
  if (!Array.isArray(cases) || cases.length === 0 || cases.length > kMaxCases)
    return `${where}: expected 1 to ${kMaxCases} cases`;
  for (const one of cases as unknown[]) {
    if (!isObject(one) || !isText(one["name"])) return `${where}: a case has no name`;
    const tracks: unknown = one["tracks"];
    if (!Array.isArray(tracks) || tracks.length === 0 || tracks.length > kMaxTracks)
      return `${where}, ${one["name"]}: expected 1 to ${kMaxTracks} tracks`;
    for (const track of tracks as unknown[]) {
      const wrong = wrongTrack(track);
      if (wrong !== undefined) return `${where}, ${one["name"]}: ${wrong}`;
    }
  }
  return undefined;
}

function wrongTrack(track: unknown): string | undefined {
  if (
    !isObject(track) ||
    !isText(track["law"]) ||
    typeof track["default"] !== "boolean" ||
    typeof track["held"] !== "boolean"
  ) {
    return "a track does not name its law, or whether it holds";
  }
  if (track["leaves_s"] !== null && !isNumber(track["leaves_s"]))
    return `${track["law"]}: leaves_s is no number and not null`;
  const figures: unknown = track["figures"];
  if (!Array.isArray(figures) || figures.length > kMaxFigures || !figures.every(isFigure))
    return `${track["law"]}: a figure cannot be read`;
  const times: unknown = track["t_s"];
  const count = Array.isArray(times) ? times.length : 0;
  if (count < 2 || count > kMaxPoints) return `${track["law"]}: expected 2 to ${kMaxPoints} points, found ${count}`;
  for (const name of kColumns) {
    const column: unknown = track[name];
    if (!Array.isArray(column) || column.length !== count || !column.every(isNumber))
      return `${track["law"]}: ${name} is not ${count} numbers`;
  }
  const time = times as number[];
  for (let i = 1; i < count; ++i)
    if (time[i]! <= time[i - 1]!) return `${track["law"]}: time does not grow at point ${i}`;
  return undefined;
}

function isFigure(value: unknown): boolean {
  return (
    isObject(value) &&
    isText(value["name"]) &&
    typeof value["unit"] === "string" &&
    isNumber(value["value"]) &&
    (value["bound"] === null || isNumber(value["bound"])) &&
    typeof value["held"] === "boolean"
  );
}

function isNumber(value: unknown): value is number {
  return typeof value === "number" && Number.isFinite(value);
}

function isText(value: unknown): value is string {
  return typeof value === "string" && value !== "";
}
