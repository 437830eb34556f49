import { formatDate, formatNumber } from "../base/format";

export interface TrendPoint {
  readonly atMs: number;
  readonly value: number;
  readonly uncertainty: number; // half width of the interval drawn around it; 0: none
}

interface Props {
  readonly points: readonly TrendPoint[]; // oldest first
  readonly unit: string;
  readonly claim?: { readonly value: number; readonly title: string } | undefined; // what it should be, as a line
  readonly label: string;
}

const kWidth = 420;
const kHeight = 190;
const kMargin = { left: 52, right: 12, top: 14, bottom: 24 };
const kHeadroom = 1.15;

// One measured quantity over days, from zero up. A table beside it has the numbers.
export function Trend({ points, unit, claim, label }: Props) {
  const first = points[0]?.atMs ?? 0;
  const span = (points.at(-1)?.atMs ?? 0) - first;
  const top = kHeadroom * Math.max(claim?.value ?? 0, ...points.map((point) => point.value + point.uncertainty), 1e-9);
  const x = (atMs: number) =>
    kMargin.left + (kWidth - kMargin.left - kMargin.right) * (span > 0 ? 0.04 + 0.92 * ((atMs - first) / span) : 0.5);
  const y = (value: number) => kHeight - kMargin.bottom - (kHeight - kMargin.top - kMargin.bottom) * (value / top);
  const levels = [0, niceStep(top), 2 * niceStep(top), 3 * niceStep(top), 4 * niceStep(top)].filter(
    (level) => level <= top,
  );
  return (
    <svg class="trend" viewBox={`0 0 ${kWidth} ${kHeight}`} role="img" aria-label={label}>
      {levels.map((level) => (
        <g key={level}>
          <line class="grid" x1={kMargin.left} x2={kWidth - kMargin.right} y1={y(level)} y2={y(level)} />
          <text x={kMargin.left - 6} y={y(level) + 4} text-anchor="end">
            {formatNumber(level, 3)}
          </text>
        </g>
      ))}
      <text x={kMargin.left - 6} y={10} text-anchor="end">
        {unit}
      </text>
      {claim !== undefined && (
        <>
          <line class="claim" x1={kMargin.left} x2={kWidth - kMargin.right} y1={y(claim.value)} y2={y(claim.value)} />
          <text class="claim-text" x={kWidth - kMargin.right} y={y(claim.value) - 5} text-anchor="end">
            {claim.title}
          </text>
        </>
      )}
      <polyline class="way" points={points.map((point) => `${x(point.atMs)},${y(point.value)}`).join(" ")} />
      {points.map((point) => (
        <g key={point.atMs}>
          <line
            class="bar-line"
            x1={x(point.atMs)}
            x2={x(point.atMs)}
            y1={y(Math.max(0, point.value - point.uncertainty))}
            y2={y(point.value + point.uncertainty)}
          />
          <circle class="point" cx={x(point.atMs)} cy={y(point.value)} r="4" />
        </g>
      ))}
      {points.length > 0 && (
        <text x={x(first)} y={kHeight - 6} text-anchor={span > 0 ? "start" : "middle"}>
          {day(first)}
        </text>
      )}
      {span > 0 && (
        <text x={x(first + span)} y={kHeight - 6} text-anchor="end">
          {day(first + span)}
        </text>
      )}
    </svg>
  );
}

// 1, 2 or 5 times a power of ten, so that two to four fit below `top`.
export function niceStep(top: number): number {
  const raw = top / 4;
  const power = 10 ** Math.floor(Math.log10(raw));
  return power * ([1, 2, 5, 10].find((factor) => factor * power >= raw) ?? 10);
}

function day(unixMs: number): string {
  return formatDate(unixMs);
}
