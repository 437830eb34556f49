import type { Deduction, Score } from "../../api/types";
import { formatMoment, formatQuantity } from "../../base/format";
import { say } from "../../base/words";

const kMeaningMm3 = 0.005; // less is not worth a line

// What the tooth and the timeline show of a mistake.
export type FaultPlace = Pick<Deduction, "position_mm" | "first_tick" | "stroke_count">;

// Where and when a mistake was made, what has most volume first. `mistake`: its number in the score.
export function deductionsOf({ deductions }: Pick<Score, "deductions">, mistake: number): Deduction[] {
  return deductions
    .filter((each) => each.mistake === mistake && each.volume_mm3 >= kMeaningMm3)
    .sort((a, b) => b.volume_mm3 - a.volume_mm3);
}

// The place of a mistake that no volume shows. Undefined: it has none either, as what was not done.
export function placeOf({ mistakes }: Pick<Score, "mistakes">, mistake: number): FaultPlace | undefined {
  const position = mistakes[mistake]?.at_mm ?? [0, 0, 0];
  return position.every((x) => x === 0) ? undefined : { position_mm: position, first_tick: 0, stroke_count: 0 };
}

// One line: how much, which way, and which strokes did it.
export function deductionText(deduction: Deduction): string {
  const volume = formatQuantity(deduction.volume_mm3, "mm3");
  if (deduction.left) return say("deduction.left", { volume });
  const [worst] = deduction.strokes;
  if (worst === undefined) return say("deduction.over", { volume });
  const told = { volume, moment: formatMoment(deduction.first_s), stroke: String(worst.number) };
  const others = deduction.stroke_count - 1;
  if (deduction.here)
    return others <= 0 ? say("deduction.here_one", told) : say("deduction.here_more", { ...told, count: others });
  return others <= 0 ? say("deduction.one", told) : say("deduction.more", { ...told, count: others });
}
