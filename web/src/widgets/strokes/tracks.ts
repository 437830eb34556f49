import type { StrokeCase, StrokeTrack } from "../../api/strokes";
import { formatNumber } from "../../base/format";

// What is drawn of a case, and how it is said.

export interface TrackLine {
  readonly label: string;
  readonly colorVariable: string;               // a CSS custom property
  readonly width: number;
  readonly dash?: readonly number[];
  readonly fill?: boolean;                      // an area down to zero instead of a line
}

// The same in every case, so that one legend serves all of them.
export const kIdealLine: TrackLine = { label: "Ideal: B · v where the bur is in tissue, 0 in air", colorVariable: "--text", width: 1.6, dash: [7, 4] };
export const kOracleLine: TrackLine = { label: "The best a coupling without memory could do", colorVariable: "--good", width: 1.4, dash: [2, 3] };
export const kWholeLine: TrackLine = { label: "The whole force of the law in use, also sideways", colorVariable: "--plot-force", width: 0, fill: true };
const kLawLines: readonly Omit<TrackLine, "label">[] = [
  { colorVariable: "--plot-force", width: 2.6 },
  { colorVariable: "--plot-removed", width: 1.3 },
  { colorVariable: "--plot-bound", width: 1.3 },
];

export function lawLine(track: StrokeTrack, index: number): TrackLine {
  const style = kLawLines[Math.min(index, kLawLines.length - 1)]!;
  return { ...style, label: track.default ? `${track.law}, the law in use` : `${track.law}, for comparison` };
}

export interface Joined {
  readonly timeS: readonly number[];
  readonly columns: readonly (readonly (number | null)[])[];
}

// Columns over the times of all tracks; null where a track has no point. `columns`: times and values.
export function joined(columns: readonly { readonly timeS: readonly number[]; readonly values: readonly number[] }[]): Joined {
  const timeS = [...new Set(columns.flatMap((column) => column.timeS))].sort((a, b) => a - b);
  const place = new Map(timeS.map((time, index) => [time, index]));
  return {
    timeS,
    columns: columns.map(({ timeS: own, values }) => {
      const out: (number | null)[] = new Array<number | null>(timeS.length).fill(null);
      own.forEach((time, index) => { out[place.get(time)!] = values[index]!; });
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
    data: joined([{ timeS: first.t_s, values: first.magnitude_n }, { timeS: first.t_s, values: first.ideal_n }, { timeS: first.t_s, values: first.oracle_n },
                  ...order.map(({ track }) => ({ timeS: track.t_s, values: track.force_n }))]),
  };
}

export interface CaseText {
  readonly title: string;
  readonly what: string;
  readonly look: string;
}

const kCases: Readonly<Record<string, CaseText>> = {
  press: { title: "Press", what: "The bur is pushed straight down into enamel at 0.5 mm/s, then held still.",
           look: "The force should climb when the dashed line does, stay on it, and fall when the hand stops." },
  stroke: { title: "Stroke", what: "The side of the bur mills into the block at 0.43 mm/s, then the hand stops.",
            look: "The force should grow with the depth of the cut, without a hump above the dashed line." },
  reverse: { title: "Reverse", what: "The same stroke, then straight back along the slot that was just cut.",
             look: "On the way back nothing is in front of the bur: the force should end soon, and not pull or push." },
  lift: { title: "Lift", what: "After a stroke the bur is lifted out of its slot at 20 mm/s.",
          look: "Nothing should hold the bur on its way up. The force of the cut, now sideways, should fade soon." },
  nick: { title: "Nick an edge", what: "The bur passes the block at 2 mm/s and catches a quarter of a millimetre of its edge.",
          look: "A short bump, as long as the dashed one, and nothing after it." },
  "slip-out": { title: "Slip out", what: "A hand that pushes with a steady force mills through a corner and breaks out into the air.",
                look: "When the corner gives way the force should fall to zero: no pull back, no kick." },
};

export function caseText(name: string): CaseText {
  return kCases[name] ?? { title: name, what: "", look: "" };
}

const kFigures: Readonly<Record<string, string>> = {
  lag_s: "Behind the ideal, at half height", rise90_s: "Time to 90 % of the force", overshoot_n: "Above the ideal, at most",
  pull_n: "Pull against the hand in air", rise_n: "Largest jump of that pull in a tick", push_n: "Push along with the hand in air",
  help_s: "How long it pushes the hand back", let_go_s: "Time to let go", step_beyond_n: "Largest step the spring does not explain",
  error_over_oracle: "Error, as a multiple of the dotted line's", ideal_peak_n: "Largest ideal force",
};

export function figureTitle(name: string): string {
  return kFigures[name] ?? name;
}

// Seconds are shown as milliseconds: that is what a hand notices.
export function figureText(value: number, unit: string): string {
  if (unit === "s") return `${formatNumber(1e3 * value, 0)} ms`;
  return `${formatNumber(value, unit === "N" ? 3 : 2)}${unit === "" ? "" : ` ${unit}`}`;
}

// The picture in a sentence, for who does not see it.
export function caseSentence(one: StrokeCase): string {
  const track = one.tracks[0]!;
  const most = (values: readonly number[]) => values.reduce((a, b) => Math.max(a, b), 0);
  const misses = track.figures.filter((figure) => !figure.held).map((figure) => figureTitle(figure.name).toLowerCase());
  return `${caseText(one.name).title}: force against time over ${formatNumber(track.t_s.at(-1)!, 1)} seconds. The largest force is ` +
         `${formatNumber(most(track.force_n), 2)} N, the ideal's is ${formatNumber(most(track.ideal_n), 2)} N. ` +
         (misses.length === 0 ? "Every judged figure is held." : `Not held: ${misses.join(", ")}.`);
}
