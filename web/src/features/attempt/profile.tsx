import { useEffect, useState } from "preact/hooks";
import { formatQuantity } from "../../base/format";
import { say } from "../../base/words";
import type { PointMm } from "../../tooth/messages";
import type { LookHandle } from "../../widgets/tooth/tooth_view";
import { distanceMm, measuredText } from "./measure";

// The surface along the line between two points, seen from where one looks: how far it is above the line or below.

const kWidth = 360;
const kHeight = 130;
const kLeft = 60;
const kBottom = 22;
const kInset = 8;
const kMinSpanMm = 0.2; // of the axis: a flat surface is drawn flat
const kSamples = 121;

export interface Deepest {
  readonly depthMm: number; // below the line; negative: the whole surface is above
  readonly atMm: number; // from the first point
}

// Undefined: there is no surface below the line.
export function deepestOf(heightMm: Float32Array, lengthMm: number): Deepest | undefined {
  let best: Deepest | undefined;
  for (const [i, height] of heightMm.entries())
    if (!Number.isNaN(height) && (best === undefined || -height > best.depthMm))
      best = { depthMm: -height, atMm: (lengthMm * i) / (heightMm.length - 1) };
  return best;
}

interface Shown {
  readonly look: LookHandle;
  readonly frames: number; // another moment is another surface
}

// What was measured between points: in words, and drawn.
export function Measured({ points, ...shown }: Shown & { readonly points: readonly PointMm[] }) {
  const [from, to] = points;
  return (
    <>
      <p class="measured" role="status">
        {measuredText(points)}
      </p>
      {from !== undefined && to !== undefined && <ProfilePlot from={from} to={to} {...shown} />}
    </>
  );
}

function deepestText({ depthMm, atMm }: Deepest): string {
  return say("measure.deepest", { depth: formatQuantity(depthMm, "mm"), at: formatQuantity(atMm, "mm") });
}

function ProfilePlot({ from, to, look, frames }: Shown & { readonly from: PointMm; readonly to: PointMm }) {
  const [heightMm, setHeight] = useState<Float32Array>();
  useEffect(() => {
    let abandoned = false;
    void look.profile?.(from, to, kSamples).then((found) => {
      if (!abandoned) setHeight(found);
    });
    return () => {
      abandoned = true;
    };
  }, [from, to, look, frames]);
  const lengthMm = distanceMm(from, to);
  const deepest = heightMm === undefined ? undefined : deepestOf(heightMm, lengthMm);
  if (heightMm === undefined || deepest === undefined) return null;
  const known = [...heightMm].filter((height) => !Number.isNaN(height));
  const [low, high] = spread(Math.min(0, ...known), Math.max(0, ...known));
  const x = (share: number) => kLeft + (kWidth - kLeft - kInset) * share;
  const y = (height: number) => kInset + ((kHeight - kBottom - kInset) * (high - height)) / (high - low);
  const said = deepestText(deepest);
  return (
    <figure class="profile">
      <svg viewBox={`0 0 ${kWidth} ${kHeight}`} role="img" aria-label={said}>
        <line class="line" x1={x(0)} x2={x(1)} y1={y(0)} y2={y(0)} />
        {piecesOf(heightMm).map((piece) => (
          <polyline key={piece[0]} points={piece.map((i) => `${x(i / (kSamples - 1))},${y(heightMm[i]!)}`).join(" ")} />
        ))}
        <circle cx={x(deepest.atMm / lengthMm)} cy={y(-deepest.depthMm)} r="4" />
        {[low, high].map((height) => (
          <text key={height} x={kLeft - 5} y={y(height) + 4} text-anchor="end">
            {formatQuantity(height, "mm")}
          </text>
        ))}
        <text x={x(0)} y={kHeight - 5}>
          a
        </text>
        <text x={x(1)} y={kHeight - 5} text-anchor="end">
          {`b: ${formatQuantity(lengthMm, "mm")}`}
        </text>
      </svg>
      <figcaption>{said}</figcaption>
    </figure>
  );
}

function spread(low: number, high: number): readonly [number, number] {
  const missing = Math.max(0, kMinSpanMm - (high - low)) / 2;
  return [low - missing, high + missing];
}

// Indices that follow each other and have a height.
function piecesOf(heightMm: Float32Array): number[][] {
  const out: number[][] = [];
  let open: number[] | undefined;
  for (const [i, height] of heightMm.entries()) {
    if (Number.isNaN(height)) {
      open = undefined;
      continue;
    }
    if (open === undefined) {
      open = [];
      out.push(open);
    }
    open.push(i);
  }
  return out;
}
