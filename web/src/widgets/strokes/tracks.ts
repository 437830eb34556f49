import type { StrokeCase, StrokeTrack } from "../../api/strokes";
import { formatNumber } from "../../base/format";
import { say, sayIf } from "../../base/words";

// The picture and the words of a case.

export interface TrackLine {
  readonly label: string;
  readonly colorVariable: string; // a CSS custom property
  readonly width: number;
  readonly dash?: readonly number[];
  readonly fill?: boolean; // an area down to zero instead of a line
}

// The same in every case, so that one legend serves all of them.
export const kIdealLine: TrackLine = {
  get label() {
    return say("strokes.ideal");
  },
  colorVariable: "--text",
  width: 1.6,
  dash: [7, 4],
};
export const kOracleLine: TrackLine = {
  get label() {
    return say("strokes.oracle");
  },
  colorVariable: "--good",
  width: 1.4,
  dash: [2, 3],
};
export const kWholeLine: TrackLine = {
  get label() {
    return say("strokes.whole");
  },
  colorVariable: "--plot-force",
  width: 0,
  fill: true,
};
const kLawLines: readonly Omit<TrackLine, "label">[] = [
  { colorVariable: "--plot-force", width: 2.6 },
  { colorVariable: "--plot-removed", width: 1.3 },
  { colorVariable: "--plot-bound", width: 1.3 },
];

export function lawLine(track: StrokeTrack, index: number): TrackLine {
  const style = kLawLines[Math.min(index, kLawLines.length - 1)]!;
  return {
    ...style,
    label: track.default
      ? say("strokes.law_used", { law: track.law })
      : say("strokes.law_compared", { law: track.law }),
  };
}

export interface Joined {
  readonly timeS: readonly number[];
  readonly columns: readonly (readonly (number | null)[])[];
}

// Columns over the times of all tracks; null where a track has no point. `columns`: times and
// values.
export function joined(
  columns: readonly { readonly timeS: readonly number[]; readonly values: readonly number[] }[],
): Joined {
  const timeS = [...new Set(columns.flatMap((column) => column.timeS))].sort((a, b) => a - b);
  const place = new Map(timeS.map((time, index) => [time, index]));
  return {
    timeS,
    columns: columns.map(({ timeS: own, values }) => {
      const out: (number | null)[] = new Array<number | null>(timeS.length).fill(null);
      own.forEach((time, index) => {
        out[place.get(time)!] = values[index]!;
      });
      return out;
    }),
  };
}

// Ideal and oracle are of the law in use: in a hand that pushes, each law has its own way.
export function drawn(one: StrokeCase): { readonly lines: readonly TrackLine[]; readonly data: Joined } {
  const first = one.tracks[0]!;
  // The law in use is drawn last, over the others.
  const order = one.tracks.map((track, index) => ({ track, line: lawLine(track, index) })).reverse();
  return {
    lines: [kWholeLine, kIdealLine, kOracleLine, ...order.map(({ line }) => line)],
    data: joined([
      { timeS: first.t_s, values: first.magnitude_n },
      { timeS: first.t_s, values: first.ideal_n },
      { timeS: first.t_s, values: first.oracle_n },
      ...order.map(({ track }) => ({ timeS: track.t_s, values: track.force_n })),
    ]),
  };
}

export interface CaseText {
  readonly title: string;
  readonly what: string;
  readonly look: string;
}

// A motion that the page does not know is called by its name.
export function caseText(name: string): CaseText {
  const key = name.replaceAll("-", "_");
  return {
    title: sayIf(`stroke_case.${key}`) ?? name,
    what: sayIf(`stroke_what.${key}`) ?? "",
    look: sayIf(`stroke_look.${key}`) ?? "",
  };
}

export function figureTitle(name: string): string {
  return sayIf(`stroke_figure.${name}`) ?? name;
}

// Seconds are shown as milliseconds: that is what a hand notices.
export function figureText(value: number, unit: string): string {
  if (unit === "s") return `${formatNumber(1e3 * value, 0)} ms`;
  return `${formatNumber(value, unit === "N" ? 3 : 2)}${unit === "" ? "" : ` ${unit}`}`;
}

// The picture in a sentence, for people who do not see it.
export function caseSentence(one: StrokeCase): string {
  const track = one.tracks[0]!;
  const most = (values: readonly number[]) => values.reduce((a, b) => Math.max(a, b), 0);
  const misses = track.figures.filter((figure) => !figure.held).map((figure) => figureTitle(figure.name));
  const told = {
    motion: caseText(one.name).title,
    seconds: formatNumber(track.t_s.at(-1)!, 1),
    force: formatNumber(most(track.force_n), 2),
    ideal: formatNumber(most(track.ideal_n), 2),
  };
  return misses.length === 0
    ? say("strokes.sentence_held", told)
    : say("strokes.sentence_missed", { ...told, figures: misses.join("; ") });
}
