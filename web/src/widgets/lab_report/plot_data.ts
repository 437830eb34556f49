import type { LabColour, LabMap, LabPlot, LabSeries, LabVerdict } from "../../api/lab_report";
import { formatNumber } from "../../base/format";
import { say } from "../../base/words";

// What is drawn of a plot of enamel-lab's, apart from drawing it.

export const kColourVariables: Readonly<Record<LabColour, string>> = {
  1: "--plot-force",
  2: "--plot-removed",
  3: "--good",
  4: "--bad",
  5: "--plot-mean",
  6: "--accent",
  7: "--warning",
  8: "--plot-bound",
  reference: "--text",
  muted: "--line-strong",
  good: "--good",
  bad: "--bad",
  chosen: "--warning",
};

export const kVerdictVariables: Readonly<Record<LabVerdict, string>> = {
  passive: "--verdict-passive",
  "stable with these grips": "--verdict-stable",
  bounded: "--verdict-bounded",
  unstable: "--verdict-unstable",
};

// A map as a plot: its curves over its cells.
export function plotOfMap(map: LabMap): LabPlot {
  const inks = ["reference", "5", "1"] as const;
  return {
    title: map.title,
    x_label: map.x_label,
    y_label: map.y_label,
    log_x: true,
    log_y: true,
    series: map.curves.map(
      (curve, index): LabSeries => ({ ...curve, colour: inks[index % inks.length]!, style: "dashes", beside: false }),
    ),
  };
}

// Where cells meet: half way between neighbours on a logarithmic axis, as far beyond the ends.
export function edgesOf(centres: readonly number[]): number[] {
  if (centres.length === 1) return [centres[0]! / 1.5, centres[0]! * 1.5];
  const inner = centres.slice(1).map((value, index) => Math.sqrt(value * centres[index]!));
  const [first, last] = [centres[0]!, centres.at(-1)!];
  return [(first * first) / inner[0]!, ...inner, (last * last) / inner.at(-1)!];
}

// One row for each point of each series: a value of one series, null in the others. Points at the
// same place of different series, or above each other, stay apart.
export function rowsOf(series: readonly LabSeries[]): { readonly x: number[]; readonly columns: (number | null)[][] } {
  const points = series.flatMap((one, at) => one.x.map((x, index) => ({ x, y: one.y[index]!, at })));
  points.sort((a, b) => a.x - b.x);
  return {
    x: points.map(({ x }) => x),
    columns: series.map((_, at) => points.map((point) => (point.at === at ? point.y : null))),
  };
}

// From least to most of all points, with room about it; what there is without any points.
export function rangeOf(values: readonly number[], log: boolean): [number, number] {
  if (values.length === 0) return log ? [1, 10] : [0, 1];
  let low = values.reduce((a, b) => Math.min(a, b));
  let high = values.reduce((a, b) => Math.max(a, b));
  if (log) return [low / 1.3, high * (high === low ? 2 : 1.6)];
  if (low === high) high = low + 1;
  const room = 0.05 * (high - low);
  // A figure that begins at zero is drawn from there.
  if (low !== 0) low -= room;
  return [low, high + room];
}

// Round places on an axis: about seven; on a logarithmic one powers of ten, or 1, 2, 3, 5 of them
// where those are few.
export function ticksOf(low: number, high: number, log: boolean): number[] {
  if (log) {
    const first = Math.ceil(Math.log10(low) - 1e-9);
    const last = Math.floor(Math.log10(high) + 1e-9);
    const step = Math.max(1, Math.trunc((last - first) / 7));
    const powers: number[] = [];
    for (let power = first; power <= last; power += step) powers.push(10 ** power);
    if (powers.length >= 3) return powers;
    const finer: number[] = [];
    for (let power = first - 1; power <= last + 1; ++power)
      finer.push(...[1, 2, 3, 5].map((factor) => factor * 10 ** power));
    return finer.filter((value) => value >= low && value <= high);
  }
  const raw = (high - low) / 6;
  const base = 10 ** Math.floor(Math.log10(raw));
  const step = ([1, 2, 5, 10].find((factor) => factor * base >= raw) ?? 10) * base;
  const out: number[] = [];
  for (let n = Math.ceil(low / step); n * step <= high + 1e-9 * step; ++n) out.push(n * step);
  return out;
}

// Between them every tick is written without an exponent.
const kMinPlain = 1e-6;
const kMaxPlain = 1e9;
const kTickDigits = 12;

// Without what binary fractions add, and without an exponent where zeros are short.
export function tickText(value: number): string {
  const short = Number(value.toPrecision(6));
  return short === 0 || (Math.abs(short) >= kMinPlain && Math.abs(short) < kMaxPlain)
    ? formatNumber(short, kTickDigits)
    : String(short);
}

// The picture in a sentence, for people who do not see it.
export function plotSentence(plot: LabPlot): string {
  const named = plot.series.filter((series) => series.label !== "" && series.x.length > 0);
  return say("lab.picture", {
    title: plot.title,
    y: plot.y_label,
    x: plot.x_label,
    what: named.map((series) => series.label).join("; "),
  });
}

export function mapSentence(map: LabMap): string {
  const counts = new Map<string, number>();
  for (const cell of map.cells) counts.set(cell, (counts.get(cell) ?? 0) + 1);
  return say("lab.picture", {
    title: map.title,
    y: map.y_label,
    x: map.x_label,
    what: [...counts].map(([verdict, count]) => `${formatNumber(count, 0)} ${verdict}`).join(", "),
  });
}
