import type { MesialX } from "../../api/tooth_number";
import { forceSize, type LiveRow } from "../../api/live";
import { formatNumber } from "../../base/format";
import { say } from "../../base/words";
import { Canvas, type Drawing } from "../../widgets/canvas";
import { extentOf, largestForce, shownSeconds } from "./track";

const kTrailSeconds = 4;
const kLeastSpanMm = 6; // shown at least, so that a still hand does not look wild
const kLeastForceN = 2;

interface Props {
  readonly rows: readonly LiveRow[];
  readonly rateHz: number;
}

// Force over the last seconds, newest on the right.
export function ForceStrip({ rows, rateHz }: Props) {
  const top = Math.max(kLeastForceN, Math.ceil(largestForce(rows)));
  const seconds = shownSeconds(rows, rateHz);
  const draw = ({ context, width, height, color }: Drawing) => {
    const end = rows.at(-1)?.tick ?? 0;
    const x = (tick: number) => width * (1 - (end - tick) / (seconds * rateHz));
    const y = (force: number) => height - 2 - (height - 16) * (force / top);
    context.strokeStyle = color("--line");
    context.fillStyle = color("--text-soft");
    context.font = "11px system-ui, sans-serif";
    for (const level of [top / 2, top]) {
      line(context, [
        [0, y(level)],
        [width, y(level)],
      ]);
      context.fillText(`${formatNumber(level, 1)} N`, 2, y(level) - 3);
    }
    context.strokeStyle = color("--plot-force");
    context.lineWidth = 1.5;
    line(
      context,
      rows.map((row) => [x(row.tick), y(forceSize(row))]),
    );
  };
  return (
    <Canvas
      className="live-strip"
      stamp={rows}
      draw={draw}
      label={say("live.force_label", { seconds: formatNumber(seconds, 0), force: formatNumber(largestForce(rows)) })}
    />
  );
}

export interface Plane {
  readonly name: "above" | "side";
  readonly right: 0 | 1 | 2; // axis of the scene that points right
  readonly up: 0 | 1 | 2;
  readonly upName: "buccal" | "occlusal";
}

export const kFromAbove: Plane = { name: "above", right: 0, up: 1, upName: "buccal" };
export const kFromLingual: Plane = { name: "side", right: 0, up: 2, upName: "occlusal" };

// Where the tool is and was, seen along one axis, with the force at the tip as an arrow.
export function AnchorView({
  rows,
  rateHz,
  plane,
  mesial,
}: Props & { readonly plane: Plane; readonly mesial: MesialX | undefined }) {
  const last = rows.at(-1);
  const draw = (drawing: Drawing) => drawAnchor(drawing, rows, rateHz, plane, mesial);
  const at =
    last === undefined
      ? say(`live.tool_${plane.name}_none`)
      : say(`live.tool_${plane.name}`, {
          right: formatNumber(last.anchorMm[plane.right] * (mesial ?? 1), 1),
          up: formatNumber(last.anchorMm[plane.up], 1),
        });
  return <Canvas className="live-anchor" stamp={rows} draw={draw} label={at} />;
}

function drawAnchor(
  { context, width, height, color }: Drawing,
  rows: readonly LiveRow[],
  rateHz: number,
  { right, up, upName }: Plane,
  mesial: MesialX | undefined,
): void {
  const last = rows.at(-1);
  const extent = extentOf(rows);
  if (last === undefined || extent === undefined) return;
  const span = Math.max(
    kLeastSpanMm,
    1.2 * (extent.high[right] - extent.low[right]),
    1.2 * (extent.high[up] - extent.low[up]),
  );
  const scale = Math.min(width, height) / span;
  const centre = [(extent.low[right] + extent.high[right]) / 2, (extent.low[up] + extent.high[up]) / 2] as const;
  const place = (row: LiveRow): Point => [
    width / 2 + (row.anchorMm[right] - centre[0]) * scale,
    height / 2 - (row.anchorMm[up] - centre[1]) * scale,
  ];
  drawGrid(context, width, height, scale, color);
  context.strokeStyle = color("--plot-bound");
  line(context, rows.map(place));
  context.strokeStyle = color("--plot-mean");
  context.lineWidth = 2;
  line(context, rows.filter((row) => row.tick >= last.tick - kTrailSeconds * rateHz).map(place));
  const [x, y] = place(last);
  context.strokeStyle = context.fillStyle = color("--plot-removed");
  const perNewton = Math.min(width, height) / 8;
  line(context, [
    [x, y],
    [x + last.forceN[right] * perNewton, y - last.forceN[up] * perNewton],
  ]);
  context.beginPath();
  context.arc(x, y, 5, 0, 2 * Math.PI);
  context.fill();
  context.fillStyle = color("--text-soft");
  context.font = "11px system-ui, sans-serif";
  context.fillText(`${say(`axis.${upName}`)} ↑`, 6, 14);
  if (mesial === undefined) return;
  context.textAlign = mesial > 0 ? "right" : "left";
  context.fillText(
    mesial > 0 ? `${say("axis.mesial")} →` : `← ${say("axis.mesial")}`,
    mesial > 0 ? width - 6 : 6,
    height - 6,
  );
}

// A line each millimetre would crowd a wide view: every one, two, five or ten.
function drawGrid(
  context: CanvasRenderingContext2D,
  width: number,
  height: number,
  scale: number,
  color: Drawing["color"],
): void {
  const step = [1, 2, 5, 10, 20, 50].find((mm) => mm * scale >= 18) ?? 100;
  context.strokeStyle = color("--line");
  context.lineWidth = 1;
  for (let x = (width / 2) % (step * scale); x < width; x += step * scale)
    line(context, [
      [x, 0],
      [x, height],
    ]);
  for (let y = (height / 2) % (step * scale); y < height; y += step * scale)
    line(context, [
      [0, y],
      [width, y],
    ]);
  context.fillStyle = color("--text-soft");
  context.font = "11px system-ui, sans-serif";
  // Above the line that has the name of a direction at its end.
  context.fillText(say("live.grid", { step: String(step) }), 6, height - 20);
}

type Point = readonly [number, number];

function line(context: CanvasRenderingContext2D, points: readonly Point[]): void {
  const [first, ...rest] = points;
  if (first === undefined) return;
  context.beginPath();
  context.moveTo(...first);
  for (const point of rest) context.lineTo(...point);
  context.stroke();
}
