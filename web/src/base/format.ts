import { dateText, numberText, spokenLanguage, spokenLocale } from "./language";

// Numbers, units and times as people read them. Values that are not finite are shown as a dash.

const kDash = "–";
const kUnits: Readonly<Record<string, string>> = {
  mm3: "mm³",
  "mm3/s": "mm³/s",
  mm2: "mm²",
  count: "",
  n: "N",
  mn: "mN",
  um: "µm",
  nm: "nm",
  percent: "%",
  deg: "°",
  "mN/mm": "mN/mm",
  "N/mm": "N/mm",
  ratio: "",
  "uN m": "µN m",
  "uN m/rad": "µN m/rad",
  "uN m s/rad": "µN m s/rad",
  urad: "µrad",
};

export function unitText(unit: string): string {
  return kUnits[unit] ?? unit;
}

// Up to `digits` decimals, a true minus sign, thin grouping of thousands.
export function formatNumber(value: number, digits = 2): string {
  if (!Number.isFinite(value)) return kDash;
  return numberText(Number(value.toFixed(digits)), 0, digits);
}

// One decimal always, so that scores in a column line up.
export function formatScore(score: number | null): string {
  return score === null || !Number.isFinite(score) ? kDash : numberText(score, 1, 1);
}

// Of a criterion: lost, kept, or to be had.
export function formatPoints(points: number): string {
  return formatNumber(points, 1);
}

const kMinLost = 0.05; // points; less rounds to nothing

// "−5.2", or "0": lost points in a table.
export function lostText(points: number): string {
  return points < kMinLost ? "0" : `−${numberText(points, 1, 1)}`;
}

export const kScoreStep = 0.1; // of a score as it is shown and set

// At the precision that a field for a score takes: a browser refuses what lies between its steps.
export function scoreForField(score: number): number {
  return Number(score.toFixed(1));
}

// As fine as anybody acts on, and as the server's reasons have it (UsualDigits in
// common/scoring/score.cpp).
const kDigits: Readonly<Record<string, number>> = {
  mm: 2,
  mm2: 2,
  mm3: 2,
  N: 2,
  "N s": 2,
  mJ: 2,
  "N/s": 2,
  "mm3/s": 2,
  ratio: 2,
  um: 2,
  "%": 1,
  deg: 1,
  count: 0,
};
export const kMaxDigits = 4;

export function usualDigits(unit: string): number | undefined {
  return kDigits[unit];
}

// With a sign unless it rounds to zero: for deviations, which are millimetres.
export function formatSigned(value: number, digits = 2): string {
  const text = formatFixed(value, digits);
  return Number(value.toFixed(digits)) > 0 ? `+${text}` : text;
}

// The one form of a measured value with its unit, wherever it is shown.
export function formatQuantity(value: number, unit: string): string {
  if (unit === "s") return formatDuration(value);
  // A wrist's friction is tenths of a millinewton metre: in newton metres it would read 0.
  if (unit === "N m" && Math.abs(value) < 0.1) return formatQuantity(value * 1000, "mN m");
  const digits = kDigits[unit];
  return withUnit(digits === undefined ? formatNumber(value, digitsFor(value)) : formatFixed(value, digits), unit);
}

// A limit of a measured value, in its form but with enough decimals to show it unrounded: 0.025 mm,
// not 0.03.
export function formatLimit(value: number, unit: string): string {
  const usual = kDigits[unit];
  if (unit === "s" || usual === undefined || !Number.isFinite(value)) return formatQuantity(value, unit);
  let digits = usual;
  while (digits < kMaxDigits && Math.abs(Number(value.toFixed(digits)) - value) > 1e-9) ++digits;
  return formatWith(value, unit, digits);
}

export function formatWith(value: number, unit: string, digits: number): string {
  return withUnit(formatFixed(value, digits), unit);
}

// Exactly so many decimals.
export function formatFixed(value: number, digits: number): string {
  if (!Number.isFinite(value)) return kDash;
  return numberText(Number(value.toFixed(digits)), digits, digits);
}

function withUnit(number: string, unit: string): string {
  const shown = unitText(unit);
  return shown === "" || number === kDash ? number : `${number}${shown === "°" ? "" : "\u00a0"}${shown}`;
}

// About three significant places.
function digitsFor(value: number): number {
  const size = Math.abs(value);
  if (size >= 100) return 0;
  if (size >= 10) return 1;
  return size >= 1 ? 2 : 3;
}

export function formatDateTime(unixMs: number): string {
  if (!Number.isFinite(unixMs) || unixMs <= 0) return kDash;
  return dateText(unixMs, true);
}

export function formatDate(unixMs: number): string {
  return dateText(unixMs, false);
}

// How long something took. Below a minute a measured time keeps its tenths.
export function formatDuration(seconds: number): string {
  if (!Number.isFinite(seconds) || seconds < 0) return kDash;
  const chinese = spokenLanguage() === "zh";
  const inWords = (value: number, unit: "minute" | "second") =>
    new Intl.NumberFormat(spokenLocale(), { style: "unit", unit, maximumFractionDigits: 1 }).format(value);
  if (seconds < 59.95) return chinese ? inWords(seconds, "second") : `${formatNumber(seconds, 1)}\u00a0s`;
  const whole = Math.round(seconds);
  const [minutes, rest] = [Math.floor(whole / 60), whole % 60];
  return chinese
    ? inWords(minutes, "minute") + inWords(rest, "second")
    : `${minutes}\u00a0min\u00a0${String(rest).padStart(2, "0")}\u00a0s`;
}

// A moment in an attempt: "2:07.4", minutes, seconds and tenths, or more decimals.
export function formatMoment(seconds: number, digits = 1): string {
  if (!Number.isFinite(seconds) || seconds < 0) return kDash;
  const perS = 10 ** digits;
  const parts = Math.round(perS * seconds);
  return `${Math.floor(parts / (60 * perS))}:${numberText((parts % (60 * perS)) / perS, digits, digits).padStart(3 + digits, "0")}`;
}

export function formatBytes(bytes: number): string {
  if (!Number.isFinite(bytes) || bytes < 0) return kDash;
  if (bytes < 1000) return `${bytes} B`;
  if (bytes < 1e6) return `${formatNumber(bytes / 1e3, 1)} kB`;
  if (bytes < 1e9) return `${formatNumber(bytes / 1e6, 2)} MB`;
  return `${formatNumber(bytes / 1e9, 2)} GB`;
}

export function micrometresAsMm(um: number): string {
  return `${formatNumber(um / 1000, 3)}\u00a0mm`;
}

// What a program says as a log line, for people: "the attempt is scored; wait" is "The attempt is scored; wait." What
// begins with a name of its own, such as target.depth_um, stays.
export function sentence(said: string): string {
  if (!/^[a-z]+[ ,]/.test(said)) return said;
  const begun = said.charAt(0).toUpperCase() + said.slice(1);
  return /[.!?:…)]$/.test(begun) ? begun : `${begun}.`;
}
