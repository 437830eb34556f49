import type { Marking } from "../../api/types";

export type Rating = 1 | 2 | 3 | 4 | 5; // clear fail, borderline, clear pass, good, excellent

// What somebody has entered for one work and not sent yet.
export interface MarkDraft {
  readonly rating: Rating | undefined;
  readonly points: Readonly<Record<string, number>>; // by criterion; NaN where it cannot be read
  readonly comments: Readonly<Record<string, string>>;
}

export const kNoMark: MarkDraft = { rating: undefined, points: {}, comments: {} };

// From the text that the browser kept, which an older page or a person may have written.
export function draftFrom(text: string): MarkDraft {
  try {
    const { rating, points, comments } = JSON.parse(text) as Partial<Record<keyof MarkDraft, unknown>>;
    return {
      rating: isRating(rating) ? rating : undefined,
      points: ofType(points, (value): value is number => typeof value === "number"),
      comments: ofType(comments, (value): value is string => typeof value === "string"),
    };
  } catch {
    return kNoMark;
  }
}

function isRating(value: unknown): value is Rating {
  return typeof value === "number" && Number.isInteger(value) && value >= 1 && value <= 5;
}

function ofType<T>(found: unknown, is: (value: unknown) => value is T): Record<string, T> {
  if (typeof found !== "object" || found === null) return {};
  return Object.fromEntries(Object.entries(found).filter((entry): entry is [string, T] => is(entry[1])));
}

type Criteria = Marking["criteria"];

// Criteria whose points are missing or out of range.
export function missing(draft: MarkDraft, criteria: Criteria): Criteria {
  return criteria.filter(({ name, max_points: most }) => {
    const given = draft.points[name];
    return given === undefined || !(given >= 0 && given <= most);
  });
}

// Full marks wherever nothing was entered yet.
export function filled(draft: MarkDraft, criteria: Criteria): MarkDraft {
  const full = Object.fromEntries(criteria.map(({ name, max_points: most }) => [name, most]));
  return { ...draft, points: { ...full, ...draft.points } };
}

// In a field: full marks may be a third of a hundred.
export function shownPoints(points: number | undefined): number | "" {
  return points !== undefined && Number.isFinite(points) ? Number(points.toFixed(2)) : "";
}

// As it is sent; undefined: something is missing.
export function complete(
  draft: MarkDraft,
  criteria: Criteria,
):
  | {
      readonly rating: Rating;
      readonly criteria: Record<string, { readonly points: number; readonly comment: string }>;
    }
  | undefined {
  if (draft.rating === undefined || missing(draft, criteria).length > 0) return undefined;
  return {
    rating: draft.rating,
    criteria: Object.fromEntries(
      criteria.map(({ name }) => [
        name,
        { points: draft.points[name] ?? 0, comment: (draft.comments[name] ?? "").trim() },
      ]),
    ),
  };
}

// Of 100, of what was entered.
export function totalOf(draft: MarkDraft, criteria: Criteria): number {
  const full = criteria.reduce((sum, { max_points: most }) => sum + most, 0);
  const given = criteria.reduce((sum, { name }) => sum + (draft.points[name] || 0), 0);
  return full > 0 ? (100 * given) / full : 0;
}

// The first work after `work` that waits for the caller's mark, from the beginning again; undefined: none does.
export function nextOf(mine: Marking["mine"], work: string | undefined): string | undefined {
  const at = mine.findIndex(({ id }) => id === work);
  return [...mine.slice(at + 1), ...mine.slice(0, at + 1)].find(({ marked, id }) => !marked && id !== work)?.id;
}
