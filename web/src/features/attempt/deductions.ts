import type { Deduction } from "../../api/types";
import { formatMoment, formatNumber, formatQuantity } from "../../base/format";

const kMeaningMm3 = 0.005;                      // less is not worth a line

// Where and when a criterion lost points, those with most volume first.
export function deductionsOf(deductions: readonly Deduction[] | undefined, criterion: string): Deduction[] {
  return (deductions ?? []).filter((each) => each.criterion === criterion && each.volume_mm3 >= kMeaningMm3)
    .sort((a, b) => b.volume_mm3 - a.volume_mm3);
}

// One line: how much, which way, and which strokes did it.
export function deductionText(deduction: Deduction): string {
  const volume = formatQuantity(deduction.volume_mm3, "mm3");
  if (deduction.left) return `${volume} left standing`;
  const [worst] = deduction.strokes;
  if (worst === undefined) return `${volume} too much`;
  const others = deduction.stroke_count - 1;
  const more = others <= 0 ? "" : others === 1 ? " and one more" : ` and ${formatNumber(others, 0)} more`;
  return `${volume} too much, first at ${formatMoment(deduction.first_s)}; mostly stroke ${worst.number}${more}`;
}
