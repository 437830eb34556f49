import type { Score } from "./types";

// How a student comes on at one exercise, criterion by criterion, over the attempts whose score may
// be seen.

export interface Done {
  readonly id: string;
  readonly atMs: number;
  readonly score: Score;
}

export interface CriterionProgress {
  readonly name: string;
  readonly title: string;
  readonly maxPoints: number; // of the newest rubric
  readonly shares: readonly number[]; // 0..1 of the points, oldest attempt first; where it was judged
  readonly best: number; // share
  readonly last: number; // share
}

export interface NextStep {
  readonly title: string;
  readonly lost: number; // points on average in the attempts looked at
  readonly times: number; // in how many of them points were lost
  readonly of: number;
  readonly reason: string; // what the newest of them says
}

const kLookedAt = 3; // the newest attempts: what was learned before is over
const kMeaningPoints = 0.5;

export function progressOf(done: readonly Done[]): CriterionProgress[] {
  const oldestFirst = [...done].sort((a, b) => a.atMs - b.atMs);
  const newest = oldestFirst.at(-1);
  return (newest?.score.criteria ?? []).flatMap(({ name, title, max_points: maxPoints }) => {
    const shares = oldestFirst.flatMap(({ score }) => {
      const one = score.criteria.find((criterion) => criterion.name === name);
      return one === undefined || one.max_points === 0 ? [] : [one.points / one.max_points];
    });
    const last = shares.at(-1);
    return last === undefined ? [] : [{ name, title, maxPoints, shares, best: Math.max(...shares), last }];
  });
}

// The criterion that lost most over the newest attempts, if it did so more than once, or there is
// only one attempt. What the newest attempt got right is learned.
export function nextStep(done: readonly Done[]): NextStep | undefined {
  const newest = [...done].sort((a, b) => b.atMs - a.atMs).slice(0, kLookedAt);
  const steps = (newest[0]?.score.criteria ?? []).map(({ name, title }): NextStep => {
    const found = newest.flatMap(({ score }) =>
      score.criteria.filter((criterion) => criterion.name === name && criterion.max_points > 0),
    );
    const losing = found.filter(losesPoints);
    return {
      title,
      lost:
        losing.reduce((sum, criterion) => sum + criterion.max_points - criterion.points, 0) /
        Math.max(1, newest.length),
      times: found[0] !== undefined && losesPoints(found[0]) ? losing.length : 0,
      of: newest.length,
      reason: losing[0]?.reason ?? "",
    };
  });
  return steps.filter((step) => step.times > (step.of > 1 ? 1 : 0)).sort((a, b) => b.lost - a.lost)[0];
}

function losesPoints({ max_points: most, points }: Score["criteria"][number]): boolean {
  return most - points >= kMeaningPoints;
}
