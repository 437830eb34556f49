import { pathOf } from "../base/document";
import { sayIf } from "../base/words";

// "/criteria/2/points": "Criteria, 3, points". A member that the page has no word for keeps its name.
export function placeText(field: string): string {
  const word = (step: string) =>
    sayIf(`document_place.${step}`) ?? sayIf(`profile_number.${step.replace(kUnit, "")}`) ?? step;
  return pathOf(field)
    .map((step) => (typeof step === "number" ? String(step + 1) : word(step)))
    .join(", ");
}

const kUnit = /_(?:mn_per_mm|mn_s_per_m|nm|um|mn|ms|g|hz|ticks)$/;
