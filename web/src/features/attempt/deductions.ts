import type { Deduction } from "../../api/types";
import { formatMoment, formatQuantity } from "../../base/format";
import { say } from "../../base/words";

const kMeaningMm3 = 0.005; // less is not worth a line

// Where and when a criterion lost points, those with most volume first.
export function deductionsOf(deductions: readonly Deduction[] | undefined, criterion: string): Deduction[] {
  return (deductions ?? [])
    .filter((each) => each.criterion === criterion && each.volume_mm3 >= kMeaningMm3)
    .sort((a, b) => b.volume_mm3 - a.volume_mm3);
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
