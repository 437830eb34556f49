import {
  formatLimit,
  formatMoment,
  formatNumber,
  formatQuantity,
  formatWith,
  kMostDigits,
  usualDigits,
} from "../base/format";
import { spokenLanguage } from "../base/language";
import { say, sayIf } from "../base/words";
import { ok } from "../base/result";
import { wordedText, wordedTitle } from "./builtin_words";
import type { Client } from "./client";
import type { ApiResult } from "./http";
import type { AssignmentInsight, Score } from "./types";

// What the server says of a score in English, in the language of the page: reasons by their codes
// (schemas/score.md, "Reasons"), titles that the built-in exercises give. In English too, so that a
// time or a unit has one form on the page. What people wrote stays as they wrote it.

type Criterion = Score["criteria"][number];
type Gate = NonNullable<Score["gates"]>[number];
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
      title: wordedTitle(criterion.title),
      reason: explanation(criterion),
    })),
    ...(score.gates === undefined
      ? {}
      : { gates: score.gates.map((gate) => ({ ...gate, title: wordedTitle(gate.title), reason: reasonText(gate) })) }),
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

export function wordedInsight(insight: AssignmentInsight): AssignmentInsight {
  const worded = <T extends { readonly title: string }>(item: T): T => ({ ...item, title: wordedTitle(item.title) });
  return spokenLanguage() === "en"
    ? insight
    : { ...insight, criteria: insight.criteria.map(worded), gates: insight.gates.map(worded) };
}

// Each code a sentence, then the rubric's comment, then under which other criterion the same mistake
// lost points. The server's own text where a code is not known or there are none.
export function reasonText(judged: Criterion | Gate): string {
  const { name, title, unit, reason, reasons = [], comment = "" } = judged;
  const told = reasons.map((each) => sentence(name, each, unit));
  if (told.length === 0 || told.includes(undefined)) return reason;
  return [sayIf("reason.title", { title: wordedTitle(title) }) ?? "", ...told, wordedText(comment), underText(judged)]
    .filter((part) => part !== "")
    .join(spokenLanguage() === "zh" ? "" : " ");
}

const kFound = "\u0001"; // where a sentence says what was found

// The same beside a table that has title and value: "Full marks up to 0.10 mm, none from 0.30 mm. Stop earlier there."
export function explanation(criterion: Criterion): string {
  const { name, unit, reason, reasons = [], comment = "" } = criterion;
  const told = reasons.map((each) => sentence(name, each, unit, kFound));
  if (told.length === 0 || told.includes(undefined)) return reason;
  return [...told.map((text = "") => withoutFound(text)), wordedText(comment), underText(criterion)]
    .filter((part) => part !== "")
    .join(spokenLanguage() === "zh" ? "" : " ");
}

// Under which other criterion the same mistake lost points.
function underText(judged: Criterion | Gate): string {
  const under = "under" in judged ? (judged.under ?? "") : "";
  return under === "" ? "" : say("reason.one_mistake", { criterion: wordedTitle(under) });
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
  while (digits < kMostDigits && limits.some(misleads)) ++digits;
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
    case "keeps":
      return sayIf("reason.keeps", { percent: formatNumber(first, 1) });
    case "stop_earlier":
    case "stop_earlier_here":
      return sayIf(`reason.${code}`, { moment: formatMoment(first), stroke: formatNumber(second, 0) });
    case "stop_earlier_by":
    case "stop_earlier_here_by":
      return sayIf(`reason.${code}`, { moment: formatMoment(first), half: formatMoment(second) });
    case "cut_further":
      return sayIf("reason.cut_further", { volume: formatQuantity(first, "mm3") });
    case "any":
      return sayIf("reason.any", { found: shown ?? measuredText(metric, first, unit) });
    case "not_in_task":
    case "not_made":
      return sayIf(`reason.${code}`);
    default:
      // What hand or bur does otherwise next time has no values.
      return code.startsWith("do_") ? sayIf(`reason.${code}`) : undefined;
  }
}
