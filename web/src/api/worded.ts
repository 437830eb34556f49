import { formatLimit, formatMoment, formatNumber, formatQuantity, formatSigned, unitText } from "../base/format";
import { spokenLanguage } from "../base/language";
import { sayIf } from "../base/words";
import { ok } from "../base/result";
import { wordedText, wordedTitle } from "./builtin_words";
import type { Client } from "./client";
import type { ApiResult } from "./http";
import type { AssignmentInsight, Score } from "./types";

// What the server says of a score in English, in the language of the page: reasons by their codes (schemas/score.md,
// "Reasons"), titles that the built-in exercises give. What people wrote stays as they wrote it.

type Criterion = Score["criteria"][number];
type Gate = NonNullable<Score["gates"]>[number];
type Reason = NonNullable<Criterion["reasons"]>[number];

// Of an attempt, in the page's words.
export async function scoreOf(client: Pick<Client, "score">, id: string, signal?: AbortSignal): Promise<ApiResult<Score>> {
  const score = await client.score(id, signal);
  return score.ok ? ok(wordedScore(score.value)) : score;
}

export function wordedScore(score: Score): Score {
  if (spokenLanguage() === "en") return score;
  return {
    ...score, criteria: score.criteria.map((criterion) => ({ ...criterion, title: wordedTitle(criterion.title), reason: reasonText(criterion) })),
    ...(score.gates === undefined ? {} : { gates: score.gates.map((gate) => ({ ...gate, title: wordedTitle(gate.title), reason: reasonText(gate) })) }),
  };
}

export function wordedInsight(insight: AssignmentInsight): AssignmentInsight {
  const worded = <T extends { readonly title: string }>(item: T): T => ({ ...item, title: wordedTitle(item.title) });
  return spokenLanguage() === "en" ? insight : { ...insight, criteria: insight.criteria.map(worded), gates: insight.gates.map(worded) };
}

// Each code a sentence, then the rubric's comment. The server's own text where a code is not known or there are none.
export function reasonText({ title, unit, reason, reasons = [], comment = "" }: Criterion | Gate): string {
  const told = reasons.map((each) => sentence(each, unit));
  if (spokenLanguage() === "en" || told.length === 0 || told.includes(undefined)) return reason;
  return [sayIf("reason.title", { title: wordedTitle(title) }) ?? "", ...told, wordedText(comment)].filter((part) => part !== "").join(spokenLanguage() === "zh" ? "" : " ");
}

function sentence({ code, values }: Reason, unit: string): string | undefined {
  const [first = Number.NaN, second, third] = values;
  const measured = (value: number | undefined) => value === undefined ? "" : unit === "s" ? formatQuantity(value, unit) : formatLimit(value, unit);
  const found = code === "within" && unit === "mm" ? `${formatSigned(first)}\u00a0${unitText(unit)}` : formatQuantity(first, unit);
  switch (code) {
    case "at_most": case "at_least": case "within":
      return sayIf(third === undefined ? `reason.${code}` : `reason.${code}_none`, { found, full: measured(second), none: measured(third) });
    case "between": return sayIf("reason.between", { found, from: measured(second), to: measured(third) });
    case "fails_above": return sayIf("reason.fails_above", { found, limit: measured(second) });
    case "device_limit": return sayIf("reason.device_limit", { found, share: formatNumber(second ?? Number.NaN, 1) });
    case "keeps": return sayIf("reason.keeps", { percent: formatNumber(first, 1) });
    case "stop_earlier": case "stop_earlier_here":
      return sayIf(`reason.${code}`, { moment: formatMoment(first), stroke: formatNumber(second ?? Number.NaN, 0) });
    case "stop_earlier_by": case "stop_earlier_here_by":
      return sayIf(`reason.${code}`, { moment: formatMoment(first), half: formatMoment(second ?? Number.NaN) });
    case "cut_further": return sayIf("reason.cut_further", { volume: formatQuantity(first, "mm3") });
    case "any": case "not_in_task": case "not_made": return sayIf(`reason.${code}`, { found });
    default: return undefined;
  }
}
