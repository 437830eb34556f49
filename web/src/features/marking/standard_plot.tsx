import { formatPoints } from "../../base/format";
import { say } from "../../base/words";
import { lineWithin, type RatedPoints } from "./results";
import type { Rating } from "./mark";

const kWidth = 420;
const kHeight = 240;
const kLeft = 44;
const kBottom = 40;
const kTop = 26;
const kRight = 16;
const kBorderline = 2;

const x = (rating: number) => kLeft + ((kWidth - kLeft - kRight) * (rating - 0.5)) / 5;
const y = (points: number) => kTop + ((kHeight - kTop - kBottom) * (100 - points)) / 100;

interface Props {
  readonly points: readonly RatedPoints[];
  readonly cut: number;
  readonly slope: number; // points for one step of the rating
}

// Points over ratings, the line through them, and where it crosses "borderline".
export function StandardPlot({ points, cut, slope }: Props) {
  const on = (rating: number) => cut + slope * (rating - kBorderline);
  const [from, to] = lineWithin(kBorderline, cut, slope, 0.6, 5.4);
  const ratings: readonly Rating[] = [1, 2, 3, 4, 5];
  return (
    <svg
      class="standard-plot"
      viewBox={`0 0 ${kWidth} ${kHeight}`}
      role="img"
      aria-label={say("marking.plot", { count: points.length, points: formatPoints(cut) })}
    >
      {[0, 25, 50, 75, 100].map((tick) => (
        <g key={tick}>
          <line class="grid" x1={kLeft} x2={kWidth - kRight} y1={y(tick)} y2={y(tick)} />
          <text x={kLeft - 6} y={y(tick) + 4} text-anchor="end">
            {tick}
          </text>
        </g>
      ))}
      {ratings.map((rating) => (
        <text key={rating} x={x(rating)} y={kHeight - kBottom + 18} text-anchor="middle">
          {say(`marking.rating_${rating}`)}
        </text>
      ))}
      <text x={(kLeft + kWidth - kRight) / 2} y={kHeight - 4} text-anchor="middle">
        {say("marking.whole_short")}
      </text>
      <text x={4} y={12}>
        {say("marking.points")}
      </text>
      <line class="fit" x1={x(from)} x2={x(to)} y1={y(on(from))} y2={y(on(to))} />
      <polyline class="cut" points={`${x(kBorderline)},${y(0)} ${x(kBorderline)},${y(cut)} ${kLeft},${y(cut)}`} />
      {points.map(({ id, rating, points: each }) => (
        <circle key={id} cx={x(rating)} cy={y(each)} r="4" />
      ))}
    </svg>
  );
}
