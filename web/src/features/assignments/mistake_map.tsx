import type { Exercise } from "../../api/types";
import { anatomyOf } from "../../api/tooth_number";
import { mistakeText } from "../../api/worded";
import { say } from "../../base/words";
import { outlinePaths } from "../../widgets/target_outline";
import { dotsOf, type NumberedMistake } from "./mistake_dots";

const kUmPerMm = 1000;
const kRoom = 0.5; // mm around what is drawn
const kText = 0.42; // mm, of numbers and names

interface Props {
  readonly mistakes: readonly NumberedMistake[];
  readonly target: Exercise["target"];
  readonly of: number; // students
}

// The task from above, as in the exercise's drawing, with the class's mistakes at their places.
export function MistakeMap({ mistakes, target, of }: Props) {
  const dots = dotsOf(mistakes, of).map((dot) => ({
    ...dot,
    title: mistakes.filter(({ number }) => number === dot.number).map(mistakeText)[0],
  }));
  const [atX = 0, atY = 0] = (target.landmark_um ?? []).map((um) => um / kUmPerMm);
  const [halfX, halfY] = [0, 1].map((axis) => (target.half_size_um[axis] ?? 0) / kUmPerMm) as [number, number];
  const outlined = target.landmark_um !== null;
  const reach = (places: readonly number[], at: number, half: number): readonly [number, number] => [
    Math.min(...places, ...(outlined ? [at - half] : [])) - kRoom,
    Math.max(...places, ...(outlined ? [at + half] : [])) + kRoom,
  ];
  if (dots.length === 0) return null;
  const [left, right] = reach(
    dots.flatMap(({ x, radius }) => [x - radius, x + radius]),
    atX,
    halfX,
  );
  const [low, high] = reach(
    dots.flatMap(({ y, radius }) => [y - radius, y + radius]),
    atY,
    halfY,
  );
  const names = sidesOf(target);
  const [middleX, middleY] = [(left + right) / 2, (low + high) / 2];
  const edge = 1.6 * kText; // for a name
  const wide = 5 * kText; // for a name beside the drawing
  const text = { "font-size": kText, "text-anchor": "middle" as const };
  return (
    <figure class="mistake-map">
      <svg
        viewBox={`${left - wide} ${-high - edge} ${right - left + 2 * wide} ${high - low + 2 * edge}`}
        role="img"
        aria-label={say("insight.map")}
      >
        {outlined && (
          <g transform={`translate(${atX} ${-atY}) scale(${1 / kUmPerMm})`}>
            {outlinePaths(target).map((path) => (
              <path key={path.d} class={path.what} d={path.d} />
            ))}
          </g>
        )}
        <text class="side" x={middleX} y={-high - 0.4 * kText} {...text}>
          {names.top}
        </text>
        <text class="side" x={middleX} y={-low + 1.1 * kText} {...text}>
          {names.bottom}
        </text>
        <text class="side" x={left - 0.3 * kText} y={-middleY} {...text} text-anchor="end">
          {names.left}
        </text>
        <text class="side" x={right + 0.3 * kText} y={-middleY} {...text} text-anchor="start">
          {names.right}
        </text>
        {dots.map(({ number, x, y, radius, title }) => (
          <g key={number}>
            <title>{title}</title>
            <circle cx={x} cy={-y} r={radius} />
            <text x={x} y={-y + 0.36 * sizeOf(number)} {...text} font-size={sizeOf(number)}>
              {number}
            </text>
          </g>
        ))}
      </svg>
      <figcaption class="hint">{say("insight.map_hint")}</figcaption>
    </figure>
  );
}

// Two digits within the smallest dot.
function sizeOf(number: number): number {
  return number < 10 ? kText : 0.75 * kText;
}

// Which sides of the tooth the drawing's edges are on (schema Target).
function sidesOf(target: Props["target"]) {
  const { mesial, up } = anatomyOf(target);
  const [right, left] =
    mesial === 1 ? [say("side.mesial"), say("side.distal")] : [say("side.distal"), say("side.mesial")];
  const [top, bottom] =
    up === "occlusal"
      ? [say("side.buccal"), say("side.lingual")]
      : [say("insight.side_root"), say("insight.side_edge")];
  return { left, right, top, bottom };
}
