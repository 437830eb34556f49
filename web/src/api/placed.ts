import { pathOf } from "../base/document";
import { sayIf } from "../base/words";
import type { ApiError } from "./http";

// What the server says of a place in a document, for people.

// Its sentence without the place it begins with, and with numbers as people write them: 1000 and
// not 1E3.
export function plainMessage({ field, message }: Pick<ApiError, "field" | "message">): string {
  const own = field !== "" && message.startsWith(`${field}: `) ? message.slice(field.length + 2) : message;
  return own.replaceAll(/(?<![\w.])-?\d+(?:\.\d+)?E[+-]?\d+(?![\w.])/g, (number) => String(Number(number)));
}

// "/criteria/2/points": "Criteria, 3, points". A member that the page has no word for keeps its name.
function placeText(field: string): string {
  const word = (step: string) =>
    sayIf(`document_place.${step}`) ?? sayIf(`profile_number.${step.replace(kUnit, "")}`) ?? step;
  return pathOf(field)
    .map((step) => (typeof step === "number" ? String(step + 1) : word(step)))
    .join(", ");
}

const kUnit = /_(?:mn_per_mm|mn_s_per_m|nm|um|mn|ms|g|hz|ticks)$/;

// The message after its place, which appears once, in words.
export function placedMessage(error: Pick<ApiError, "field" | "message">, place = placeText(error.field)): string {
  return place === "" ? plainMessage(error) : `${place}: ${plainMessage(error)}`;
}
