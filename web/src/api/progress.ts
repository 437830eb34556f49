import type { Mistake, Score } from "./types";
import { mistakeText, remedyText } from "./worded";
import { kWorthAdvice } from "./worth";

// How a student comes on at one exercise, over the attempts whose score may be seen.

export interface Done {
  readonly id: string;
  readonly atMs: number;
  readonly score: Score;
}

export interface CriterionProgress {
  readonly name: string;
  readonly title: string;
  readonly most: number; // points that are drawn as all there are
  readonly lost: readonly number[]; // points, oldest attempt first; where it was judged
  readonly least: number;
  readonly last: number;
}

export interface NextStep {
  readonly title: string; // what the newest attempt shows
  readonly lost: number; // points on average in the attempts looked at
  readonly times: number; // in how many of them
  readonly of: number;
  readonly remedy: string;
}

const kLookedAt = 3; // the newest attempts: what was learned before is over

export function progressOf(done: readonly Done[]): CriterionProgress[] {
  const oldestFirst = [...done].sort((a, b) => a.atMs - b.atMs);
  const newest = oldestFirst.at(-1);
  return (newest?.score.criteria ?? []).flatMap(({ name, title, most }) => {
    const lost = oldestFirst.flatMap(({ score }) => {
      const one = score.criteria.find((criterion) => criterion.name === name);
      return one === undefined || !one.judged ? [] : [one.lost];
    });
    const last = lost.at(-1);
    // A group may cost more than a person who marks it can take off.
    const all = Math.max(most, ...lost);
    return last === undefined ? [] : [{ name, title, most: all, lost, least: Math.min(...lost), last }];
  });
}

interface Loss {
  readonly key: string;
  readonly title: string;
  readonly lost: number;
  readonly remedy: string;
}

// What cost most over the newest attempts, if it came more than once or there is only one attempt. What the newest
// attempt got right is learned.
export function nextStep(done: readonly Done[]): NextStep | undefined {
  const newest = [...done].sort((a, b) => b.atMs - a.atMs).slice(0, kLookedAt);
  const losses = newest.map(({ score }) => lossesOf(score));
  const steps = (losses[0] ?? []).map(({ key, title, remedy }): NextStep => {
    const same = losses.flatMap((each) => each.find((loss) => loss.key === key) ?? []);
    const lost = same.reduce((sum, loss) => sum + loss.lost, 0) / newest.length;
    return { title, lost, times: same.length, of: newest.length, remedy };
  });
  return steps.filter(({ times, of }) => times > (of > 1 ? 1 : 0)).sort((a, b) => b.lost - a.lost)[0];
}

// Mistakes by kind and place, whose points one attempt may lose in several pieces, and figures of the hand.
function lossesOf({ mistakes, criteria }: Score): Loss[] {
  const keyOf = ({ kind, place }: Mistake) => `${kind} ${place}`;
  const dearest = new Map<string, Loss>();
  for (const mistake of mistakes) {
    const key = keyOf(mistake);
    const before = dearest.get(key);
    dearest.set(
      key,
      before === undefined
        ? { key, title: mistakeText(mistake), lost: mistake.points, remedy: remedyText(mistake) }
        : { ...before, lost: before.lost + mistake.points },
    );
  }
  const hand = criteria
    .filter(({ group }) => group === "hand")
    .map(({ name, title, lost, reason }): Loss => ({ key: name, title, lost, remedy: reason }));
  return [...dearest.values(), ...hand].filter(({ lost }) => lost >= kWorthAdvice);
}
