import type { ClassMistake } from "./insight";

// Where a class's mistakes are, as dots on a plan of the tooth.

export interface Dot {
  readonly number: number;
  readonly x: number; // mm, to the right
  readonly y: number; // mm, up
  readonly radius: number; // mm; its area is the share of students
}

export type NumberedMistake = ClassMistake & { readonly number: number };

const kLargest = 0.62; // mm, of a mistake that everybody made
const kSmallest = 0.3; // so that its number can be read
const kRounds = 60;

// Dots that would cover each other move apart by as little as they can. Those without a finite place are left out.
export function dotsOf(mistakes: readonly NumberedMistake[], students: number): readonly Dot[] {
  const dots = mistakes.flatMap(({ number, at_mm: [x = Number.NaN, y = Number.NaN], students: made }) =>
    Number.isFinite(x) && Number.isFinite(y)
      ? [{ number, x, y, radius: Math.max(kSmallest, kLargest * Math.sqrt(made / Math.max(1, students))) }]
      : [],
  );
  for (let round = 0; round < kRounds; ++round) {
    let covered = false;
    dots.forEach((a, i) => {
      for (const b of dots.slice(i + 1)) covered = part(a, b) || covered;
    });
    if (!covered) break;
  }
  return dots;
}

type Moving = { -readonly [Member in keyof Dot]: Dot[Member] };

// Whether the two covered each other.
function part(a: Moving, b: Moving): boolean {
  const [dx, dy] = [b.x - a.x, b.y - a.y];
  const distance = Math.hypot(dx, dy);
  const missing = a.radius + b.radius - distance;
  if (missing <= 1e-6) return false;
  // At one place: each pair parts in a direction of its own.
  const turn = a.number + 2 * b.number;
  const [ux, uy] = distance > 1e-9 ? [dx / distance, dy / distance] : [Math.cos(turn), Math.sin(turn)];
  a.x -= (ux * missing) / 2;
  a.y -= (uy * missing) / 2;
  b.x += (ux * missing) / 2;
  b.y += (uy * missing) / 2;
  return true;
}
