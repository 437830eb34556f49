import {
  formatLimit,
  formatNumber,
  formatPoints,
  formatQuantity,
  formatWith,
  kMaxDigits,
  usualDigits,
} from "../base/format";
import { spokenLanguage } from "../base/language";
import { say, sayIf } from "../base/words";
import { ok } from "../base/result";
import { wordedText, wordedTitle } from "./builtin_words";
import type { Client } from "./client";
import type { ApiResult } from "./http";
import type { AssignmentInsight, Criterion, Mistake, Region, Score } from "./types";

// What the server says of a score, in the language of the page: mistakes, places and reasons by their codes
// (schemas/score.md), titles that the built-in exercises give. In English too, so that a time or a unit has one form on
// the page. What people wrote stays as they wrote it.

type Critical = Score["critical"][number];
type Reason = NonNullable<Criterion["reasons"]>[number];

// Of an attempt, in the page's words.
export async function scoreOf(
  client: Pick<Client, "score">,
  id: string,
  signal?: AbortSignal,
): Promise<ApiResult<Score>> {
  const score = await client.score(id, signal);
  return score.ok ? ok(wordedScore(score.value)) : score;
}

export function wordedScore(score: Score): Score {
  return {
    ...score,
    critical: score.critical.map((critical) => ({ ...critical, reason: criticalText(critical) })),
    criteria: score.criteria.map((criterion) => ({
      ...criterion,
      title: criterionTitle(criterion),
      reason: explanation(criterion),
    })),
  };
}

// "The pulp is exposed (0.4 mm², at most 0 mm²)."
export function criticalText({ error, name, value, unit, limit, above, reason }: Critical): string {
  const said = sayIf(`critical_error.${error}`);
  if (said === undefined) return reason;
  return say(above ? "critical.at_most" : "critical.at_least", {
    error: said,
    found: measuredText(name, value, unit, formBeside(value, [limit], true, unit)),
    limit: formatLimit(limit, unit),
  });
}

// "Borderline: “The pulp is exposed” is not certain (0.02 mm², limit 0 mm², standard uncertainty 0.01 mm²)."
export function borderlineText({ error, value, unit, limit, uncertainty }: Score["borderline"][number]): string {
  if (error === "points") {
    return say("borderline.points", {
      found: formatPoints(value),
      limit: formatPoints(limit),
      uncertainty: formatPoints(uncertainty),
    });
  }
  return say("borderline.critical", {
    error: sayIf(`critical_error.${error}`) ?? plainName(error),
    found: sizeText(value, unit),
    limit: formatLimit(limit, unit),
    uncertainty: sizeText(uncertainty, unit),
  });
}

export function wordedInsight(insight: AssignmentInsight): AssignmentInsight {
  return {
    ...insight,
    criteria: insight.criteria.map((criterion) => ({ ...criterion, title: criterionTitle(criterion) })),
  };
}

// Of a group of regions its name; of a figure of the hand what the rubric calls it.
export function criterionTitle({ name, title }: { readonly name: string; readonly title: string }): string {
  return sayIf(`group.${name}`) ?? wordedTitle(title);
}

// What was done, a short line: "Distal wall: over-extended by 0.32 mm".
export function mistakeText({ kind, place, size, unit }: Pick<Mistake, "kind" | "place" | "size" | "unit">): string {
  const where = placeText(place);
  const values = { place: where, size: sizeText(size, unit) };
  return (
    sayIf(`mistake.${kind}`, values) ?? [where, plainName(kind), values.size].filter((part) => part !== "").join(" ")
  );
}

// What the hand does differently next time, a sentence. Empty: this page does not know the kind.
export function remedyText({ kind }: Pick<Mistake, "kind">): string {
  return sayIf(`mistake_do.${kind}`) ?? "";
}

// "Distal wall": of a region's name, or of a kind of region. Empty for the whole.
export function placeText(place: string): string {
  return sayIf(`place.${place}`) ?? plainName(place);
}

// "Distal wall", or what the whole paid for: "Adjacent tooth".
export function regionTitle({ name, kind }: Pick<Region, "name" | "kind">): string {
  return sayIf(`place.${name}`) ?? sayIf(`price_kind.${kind}`) ?? plainName(name);
}

// How far the dearer side of a region is off: "0.32 mm too much". Empty: it is not off.
export function regionText({ dearer, over, left, unit }: Pick<Region, "dearer" | "over" | "left" | "unit">): string {
  const size = dearer === "over" ? over : left;
  return size > 0 ? say(`score.region_${dearer}`, { size: sizeText(size, unit) }) : "";
}

// A code of a newer server, as words.
function plainName(code: string): string {
  const words = code.replaceAll("_", " ");
  return words.charAt(0).toUpperCase() + words.slice(1);
}

// As finely as people act on it, and never 0: what cost points has a size.
function sizeText(size: number, unit: string): string {
  let digits = unit === "%" ? 0 : (usualDigits(unit) ?? kMaxDigits);
  while (size > 0 && digits < kMaxDigits && Number(size.toFixed(digits)) === 0) ++digits;
  return formatWith(size, unit, digits);
}

// Each code a sentence, then the rubric's comment. The server's own text where a code is not known or there are none.
export function reasonText({ name, title, unit, reason, reasons = [], comment = "" }: Judged): string {
  const told = reasons.map((each) => sentence(name, each, unit));
  if (told.length === 0 || told.includes(undefined)) return reason;
  return [say("reason.title", { title: wordedTitle(title) }), ...told, wordedText(comment)]
    .filter((part) => part !== "")
    .join(spokenLanguage() === "zh" ? "" : " ");
}

type Judged = Pick<Criterion, "name" | "title" | "unit" | "reason" | "reasons" | "comment">;

const kFound = "\u0001"; // where a sentence says what was found

// The same beside a table that has title and value: "Full marks up to 0.10 mm, none from 0.30 mm. Stop earlier there."
export function explanation({ name, unit, reason, reasons = [], comment = "" }: Judged): string {
  const told = reasons.map((each) => sentence(name, each, unit, kFound));
  if (told.length === 0 || told.includes(undefined)) return reason;
  return [...told.map((text = "") => withoutFound(text)), wordedText(comment)]
    .filter((part) => part !== "")
    .join(spokenLanguage() === "zh" ? "" : " ");
}

// In every language such a sentence is what was found, then its limits in brackets.
function withoutFound(text: string): string {
  const [, limits = "", end = ""] = new RegExp(`^${kFound} *(?:[(（](.*)[)）])?([.。])$`).exec(text) ?? [];
  if (limits !== "") return limits.charAt(0).toLocaleUpperCase(spokenLanguage()) + limits.slice(1) + end;
  return end === "" ? text : "";
}

// What lies above and below zero of a measurement whose sign says which way: MetricInfo in
// common/scoring/registry.
export function directionsOf(metric: string): readonly [above: string, below: string] | undefined {
  const [, kind, unit] = /^(\w+)_(?:mesial|distal|buccal|lingual)_(\w+)/.exec(metric) ?? [];
  if (unit === "deg") return ["more_open_at_the_top", "undercut"];
  const below =
    kind === "wall"
      ? "short"
      : metric === "floor_mm"
        ? "too_shallow"
        : metric === "finish_depth_mm"
          ? "too_high"
          : undefined;
  return below === undefined ? undefined : ["too_deep", below];
}

const kLeast = 0.005; // less is neither

// A measured value; where its sign says which way, in words: "0.22 mm too deep".
export function measuredText(
  metric: string,
  value: number,
  unit: string,
  form = (size: number) => formatQuantity(size, unit),
): string {
  const directions = directionsOf(metric);
  if (directions === undefined || !Number.isFinite(value)) return form(value);
  const size = form(Math.abs(value));
  return sayIf(`direction.${Math.abs(value) < kLeast ? "none" : directions[value > 0 ? 0 : 1]}`, { size }) ?? size;
}

// The form of what was found, beside its limits: with as many decimals as keep it on its side of
// each. A value that misses must not read like the limit; one that does not may.
function formBeside(value: number, limits: readonly number[], missed: boolean, unit: string) {
  let digits = usualDigits(unit);
  if (digits === undefined) return (size: number) => formatQuantity(size, unit);
  const misleads = (limit: number) => {
    const shown = Number(value.toFixed(digits));
    if (Math.abs(shown - limit) < 1e-9) return missed && value !== limit;
    return shown > limit !== value > limit;
  };
  while (digits < kMaxDigits && limits.some(misleads)) ++digits;
  return (size: number) => formatWith(size, unit, digits);
}

// `shown`: what stands for the value that was found; undefined: the value.
function sentence(metric: string, { code, values }: Reason, unit: string, shown?: string): string | undefined {
  const [first = Number.NaN, second = Number.NaN, third = Number.NaN] = values;
  // Where no points are left any more is read as about there.
  const limits = values.slice(1, code === "between" ? 3 : 2);
  const compared = code === "within" ? Math.abs(first) : first;
  const told = (missed: boolean) => ({
    found: shown ?? measuredText(metric, first, unit, formBeside(compared, limits, missed, unit)),
    second: formatLimit(second, unit),
    third: formatLimit(third, unit),
  });
  const none = values.length > 2 ? "_none" : "";
  switch (code) {
    case "at_most":
    case "at_least":
    case "within": {
      const {
        found,
        second: full,
        third: zero,
      } = told(code === "at_least" ? first < second : (code === "within" ? Math.abs(first) : first) > second);
      // One value alone earns them: no pulp exposed.
      return sayIf(`reason.${code !== "at_least" && second === 0 ? "exactly" : code}${none}`, {
        found,
        full,
        none: zero,
      });
    }
    case "between": {
      const { found, second: from, third: to } = told(first < second || first > third);
      return second === third
        ? sayIf("reason.exactly", { found, full: from })
        : sayIf("reason.between", { found, from, to });
    }
    case "fails_above": {
      const { found, second: limit } = told(true);
      return sayIf("reason.fails_above", { found, limit });
    }
    case "device_limit":
      return sayIf("reason.device_limit", { found: formatQuantity(first, unit), share: formatNumber(second, 1) });
    case "below_grid":
      return sayIf("reason.below_grid", { limit: formatLimit(first, unit) });
    case "any":
      return sayIf("reason.any", { found: shown ?? measuredText(metric, first, unit) });
    case "not_in_task":
    case "not_made":
    case "do_lighter":
      return sayIf(`reason.${code}`);
    default:
      return undefined; // of a newer server
  }
}
