import type { Exercise } from "../../api/types";
import { kContourStepMm } from "../../tooth/deviation_scale";

type Criteria = Exercise["rubric"]["criteria"];

// How far a wall may lie from the reference's and still has full marks: the rubric's own number,
// the strictest of its walls and floor, or else of the distance as a whole. A line of the scale
// where the rubric judges neither.
export function toleranceMm(criteria: Criteria): number {
  return (
    strictest(criteria, /^(wall_(mesial|distal|buccal|lingual)|floor)_mm$/) ??
    strictest(criteria, /^deviation_rms_mm$/) ??
    kContourStepMm
  );
}

function strictest(criteria: Criteria, metric: RegExp): number | undefined {
  const bounds = criteria
    .filter((criterion) => metric.test(criterion.metric))
    .flatMap(({ map }) => {
      const full = map.filter((point) => point.share >= 1).map((point) => point.value);
      return full.length === 0 ? [] : [Math.max(...full)];
    });
  return bounds.length === 0 ? undefined : Math.min(...bounds);
}
