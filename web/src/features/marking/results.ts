import type { Marking, MarkingResults } from "../../api/types";
import type { Cell } from "../../base/csv";
import { formatNumber } from "../../base/format";

// The marks as schemas/marks.md has them, which `enamel-server agreement` and `standard` read.
export function marksTable(
  marking: Marking,
  { works }: MarkingResults,
): { readonly header: readonly string[]; readonly rows: ReadonlyArray<readonly Cell[]> } {
  const names = new Map(marking.markers.map(({ id, display_name: name }) => [id, name === "" ? id : name]));
  const rows = works.flatMap(({ attempt_id: work, marks }) =>
    marks.flatMap(({ marker_id: id, rating, total, criteria }): Cell[][] => {
      const marker = names.get(id) ?? id;
      return [
        ...criteria.map(({ title, points, max_points: most }) => [work, title, most, marker, points]),
        [work, "total", 100, marker, total],
        [work, "rating", 5, marker, rating],
      ];
    }),
  );
  return { header: ["work", "criterion", "full_marks", "marker", "mark"], rows };
}

export type CriterionAgreement = MarkingResults["agreement"][number];

// Nothing was marked by two people: one sentence says so, in place of a table without figures.
export function markedAlone(agreement: readonly CriterionAgreement[]): boolean {
  return agreement.every(({ why }) => why !== undefined);
}

// A rating that a marker gave, and the points of that work: the program's, else the mean of the markers' totals.
export interface RatedPoints {
  readonly id: string;
  readonly rating: number;
  readonly points: number;
}

// What borderline regression puts on each other.
export function ratedPoints(works: MarkingResults["works"]): RatedPoints[] {
  const computed = works.some(({ computed_score: score }) => score !== null);
  return works.flatMap(({ id, marks, computed_score: score }) => {
    const points = computed ? score : marks.reduce((sum, { total }) => sum + total, 0) / marks.length;
    if (points === null) return [];
    return marks.map(({ marker_id: marker, rating }) => ({ id: `${id} ${marker}`, rating, points }));
  });
}

// The part of the line through (`at`, `value`) with that slope that lies within 0 and 100 points and `from` to `to`.
export function lineWithin(at: number, value: number, slope: number, from: number, to: number) {
  const ratingOf = (points: number) => at + (points - value) / slope;
  const [low, high] = slope > 0 ? [ratingOf(0), ratingOf(100)] : [from, to];
  return [Math.max(from, low), Math.min(to, high)] as const;
}

// Of agreement, where 1 is perfect: cut off after two decimals, or 0.996 would be shown as certain. The room is for what
// 100 times 0.29 is short of 29.
export function formatCoefficient(value: number): string {
  return formatNumber(Math.floor(100 * value + 1e-9) / 100);
}
