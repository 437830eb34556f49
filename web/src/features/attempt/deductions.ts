import type { Deduction } from "../../api/types";
import { formatNumber } from "../../base/format";

const kMeaningMm3 = 0.005;                      // less is not worth a line

// "1:12": minutes and seconds into the attempt.
export function clockText(seconds: number): string {
  const whole = Math.max(0, Math.floor(seconds));
  return `${Math.floor(whole / 60)}:${String(whole % 60).padStart(2, "0")}`;
}

// Where and when a criterion lost points, those with most volume first.
export function deductionsOf(deductions: readonly Deduction[] | undefined, criterion: string): Deduction[] {
  return (deductions ?? []).filter((each) => each.criterion === criterion && each.volume_mm3 >= kMeaningMm3)
    .sort((a, b) => b.volume_mm3 - a.volume_mm3);
}

// One line: how much, which way, and which strokes did it.
export function deductionText(deduction: Deduction): string {
  const volume = `${formatNumber(deduction.volume_mm3, 2)}\u00a0mm³`;
  if (deduction.left) return `${volume} left standing`;
  const [worst] = deduction.strokes;
  if (worst === undefined) return `${volume} too much`;
  const others = deduction.stroke_count - 1;
  const more = others <= 0 ? "" : others === 1 ? " and one more" : ` and ${formatNumber(others, 0)} more`;
  return `${volume} too much, first at ${clockText(deduction.first_s)}; mostly stroke ${worst.number}${more}`;
}
