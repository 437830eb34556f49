import { formatNumber, formatPoints, unitText } from "../../base/format";
import { say } from "../../base/words";
import { costAt, curveOf, kSides, type Price, priceTitle, type Side } from "./price";

const kWidth = 310;
const kHeight = 132;
const kMargin = { left: 34, right: 72, top: 8, bottom: 24 };
const kSizes = 2; // the larger of the price's sizes, so many times, is at the end
const kSteps = 48;
const kLine = 12; // of text
const kNumber = 24; // width of a size
const kRoom = 1.06; // above the most

// Points over the size of a fault, with the points from which on a change, or new work, is asked for.
export function PriceCurve({ price }: { readonly price: Price }) {
  const { most, modify_points: modify, redo_points: redo, unit } = price;
  const lines = kSides.flatMap((side) => {
    const curve = curveOf(price, side);
    return curve === undefined ? [] : [{ side, curve }];
  });
  const end = kSizes * Math.max(...lines.map(({ curve }) => curve.size));
  const top = kRoom * most;
  const x = (size: number) => kMargin.left + ((kWidth - kMargin.left - kMargin.right) * size) / end;
  const y = (points: number) =>
    kHeight - kMargin.bottom - ((kHeight - kMargin.top - kMargin.bottom) * Math.min(points, top)) / top;
  const same = lines.length === 2 && lines[0]!.curve.size === lines[1]!.curve.size;
  const drawn = same ? lines.slice(0, 1) : lines;
  const ends = apart(drawn.map(({ curve }) => y(costAt(curve, end))));
  const ticks = [...new Set(drawn.map(({ curve }) => curve.size)), end].filter(
    (size, i, all) => i === all.length - 1 || x(all[i + 1]!) - x(size) > kNumber,
  );
  const levels = [most, redo, modify].filter(
    (points, i, all) => points <= most && all.slice(0, i).every((other) => Math.abs(y(other) - y(points)) >= kLine),
  );
  return (
    <svg
      class="price-curve"
      viewBox={`0 0 ${kWidth} ${kHeight}`}
      role="img"
      aria-label={say("price.curve", { part: priceTitle(price.of) })}
    >
      <Band from={modify} to={Math.min(redo, top)} y={y} className="modify" />
      <Band from={redo} to={top} y={y} className="redo" />
      <line class="axis" x1={x(0)} x2={x(0)} y1={y(top)} y2={y(0)} />
      <line class="axis" x1={x(0)} x2={x(end)} y1={y(0)} y2={y(0)} />
      {levels.map((points) => (
        <text key={points} x={x(0) - 4} y={y(points) + 4} text-anchor="end">
          {formatPoints(points)}
        </text>
      ))}
      {ticks.map((size) => (
        <g key={size}>
          <line class="axis" x1={x(size)} x2={x(size)} y1={y(0)} y2={y(0) + 4} />
          <text x={x(size)} y={kHeight - 8} text-anchor="middle">
            {formatNumber(size, 4) + (size === end ? `\u00a0${unitText(unit)}` : "")}
          </text>
        </g>
      ))}
      {y(redo) - y(top) > kLine && redo < most && (
        <text class="state" x={x(0) + 5} y={y(top) + kLine - 1}>
          {say("grade_state.redo")}
        </text>
      )}
      {y(modify) - y(redo) > kLine && modify < most && (
        <text class="state" x={x(end) - 5} y={y(modify) - 4} text-anchor="end">
          {say("grade_state.modify")}
        </text>
      )}
      {drawn.map(({ side, curve }, i) => (
        <g key={side} class={side}>
          <polyline
            points={Array.from({ length: kSteps + 1 }, (_, step) => (step * end) / kSteps)
              .map((size) => `${x(size).toFixed(1)},${y(costAt(curve, size)).toFixed(1)}`)
              .join(" ")}
          />
          <circle cx={x(curve.size)} cy={y(costAt(curve, curve.size))} r="3" />
          {lines.length === 2 && (
            <text x={x(end) + 5} y={ends[i]! + 4}>
              {same ? say("price.both_sides") : sideText(side)}
            </text>
          )}
        </g>
      ))}
    </svg>
  );
}

function sideText(side: Side): string {
  return say(side === "over" ? "price.too_far" : "price.left");
}

function Band({
  from,
  to,
  y,
  className,
}: {
  readonly from: number;
  readonly to: number;
  readonly y: (points: number) => number;
  readonly className: string;
}) {
  return (
    to > from && (
      <rect
        class={className}
        x={kMargin.left}
        width={kWidth - kMargin.left - kMargin.right}
        y={y(to)}
        height={y(from) - y(to)}
      />
    )
  );
}

// Two lines of text that may not cover each other, the upper one first.
function apart(heights: readonly number[]): readonly number[] {
  const [upper, lower] = heights;
  if (upper === undefined || lower === undefined || lower - upper >= kLine) return heights;
  const middle = (upper + lower) / 2;
  return [middle - kLine / 2, middle + kLine / 2];
}
