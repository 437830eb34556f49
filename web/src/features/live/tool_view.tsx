import type { LiveRow } from "../../api/live";
import { type Anatomy, anatomyOf, fromScene } from "../../api/tooth_number";
import type { Attempt, Exercise, Target } from "../../api/types";
import { formatNumber, formatQuantity } from "../../base/format";
import { say } from "../../base/words";
import { Canvas, type Drawing } from "../../widgets/canvas";
import { kTargetColor } from "../../tooth/line_colors";
import type { Axis, Plane, ToothPlan } from "../../tooth/messages";
import { outlinePaths } from "../../widgets/target_outline";
import { burRadiiMm, type Cut, depthsOf } from "./cut";
import { line, type Point } from "./lines";
import { extentOf } from "./track";

const kTrailSeconds = 4;
const kMinSpanMm = 6; // shown at least, so that a still hand does not look wild
const kRoom = 1.1; // around a tooth
const kToothAlpha = 0.5; // the way of the tool is read over it, in both themes
const kEdgePx = 6; // where a tool beside the picture is drawn

type Triple = readonly [number, number, number];

export interface Side extends Plane {
  readonly name: "above" | "side";
}

export const kFromAbove: Side = { name: "above", right: 0, up: 1 };
export const kFromSide: Side = { name: "side", right: 0, up: 2 };

// What is worked on, in the scene's frame. None: it is not known (yet), and the way of the tool is shown alone.
export interface Workpiece {
  readonly anatomy: Anatomy;
  readonly target: Target;
  readonly plan: ToothPlan | undefined; // of the plane that is shown
  readonly originMm: Triple | undefined; // where the rows' places are counted from
  readonly bursMm: readonly number[]; // radii
  readonly cut: Cut | undefined; // where it was cut so far; undefined: not known (yet)
}

export function workpieceOf(
  exercise: Exercise | undefined,
  plan: ToothPlan | undefined,
  { device_origin_um: origin }: Pick<Attempt, "device_origin_um">,
  cut: Cut | undefined,
): Workpiece | undefined {
  if (exercise === undefined) return undefined;
  const originMm = origin?.map((um) => um / 1000) as unknown as Triple | undefined;
  return {
    anatomy: anatomyOf(exercise.target),
    target: exercise.target,
    plan,
    originMm,
    bursMm: burRadiiMm(exercise),
    cut,
  };
}

interface Props {
  readonly rows: readonly LiveRow[];
  readonly rateHz: number;
  readonly plane: Side;
  readonly workpiece: Workpiece | undefined;
}

// Where the tool is and was, seen along one axis, over the tooth where that is known, with the force at the tip as
// an arrow.
export function ToolView({ rows, rateHz, plane, workpiece }: Props) {
  const frame = frameOf(rows, plane, workpiece);
  const draw = (drawing: Drawing) => drawTool(drawing, rows, rateHz, plane, workpiece, frame);
  return (
    <Canvas
      className="live-tool"
      stamp={[rows, workpiece]}
      draw={draw}
      label={labelOf(rows.at(-1), plane, workpiece, frame)}
    />
  );
}

// The part of the plane that is shown, in mm, and what is added to a row's place.
interface Frame {
  readonly centre: Point;
  readonly span: Point;
  readonly origin: Triple;
  readonly plan: ToothPlan | undefined;
}

function frameOf(rows: readonly LiveRow[], { right, up }: Plane, workpiece: Workpiece | undefined): Frame | undefined {
  const { plan, originMm: origin } = workpiece ?? {};
  if (plan !== undefined && origin !== undefined) {
    const [wide, tall] = [plan.width * plan.cellMm, plan.height * plan.cellMm];
    return {
      centre: [plan.lowMm[0] + wide / 2, plan.lowMm[1] + tall / 2],
      span: [kRoom * wide, kRoom * tall],
      origin,
      plan,
    };
  }
  const extent = extentOf(rows);
  if (extent === undefined) return undefined;
  const along = (axis: Axis) => Math.max(kMinSpanMm, 1.2 * (extent.high[axis] - extent.low[axis]));
  const middle = (axis: Axis) => (extent.low[axis] + extent.high[axis]) / 2;
  const span = Math.max(along(right), along(up));
  return { centre: [middle(right), middle(up)], span: [span, span], origin: [0, 0, 0], plan: undefined };
}

function labelOf(
  last: LiveRow | undefined,
  plane: Side,
  workpiece: Workpiece | undefined,
  frame: Frame | undefined,
): string {
  if (last === undefined || frame === undefined) return say(`live.tool_${plane.name}_none`);
  const place = last.anchorMm.map((value, axis) => value + frame.origin[axis as Axis]);
  return say(`live.tool_${plane.name}${frame.plan === undefined ? "" : "_tooth"}`, {
    right: formatNumber(place[plane.right]! * (workpiece?.anatomy.mesial ?? 1), 1),
    up: formatNumber(place[plane.up]!, 1),
    side: sideOf(plane.up, workpiece?.anatomy),
  });
}

// What an axis of the scene points to, in words.
function sideOf(axis: Axis, anatomy: Anatomy | undefined): string {
  const unit: Triple = [axis === 0 ? 1 : 0, axis === 1 ? 1 : 0, axis === 2 ? 1 : 0];
  const [, buccal, occlusal] = anatomy === undefined ? unit : fromScene(anatomy, unit);
  return buccal !== 0 ? say("axis.buccal") : say(occlusal > 0 ? "axis.occlusal" : "axis.apical");
}

function drawTool(
  drawing: Drawing,
  rows: readonly LiveRow[],
  rateHz: number,
  plane: Side,
  workpiece: Workpiece | undefined,
  frame: Frame | undefined,
): void {
  const last = rows.at(-1);
  if (last === undefined || frame === undefined) return;
  const { context, width, height, color } = drawing;
  const { right, up } = plane;
  const scale = Math.min(width / frame.span[0], height / frame.span[1]);
  const at = (x: number, y: number): Point => [
    width / 2 + (x - frame.centre[0]) * scale,
    height / 2 - (y - frame.centre[1]) * scale,
  ];
  const place = ({ anchorMm }: LiveRow): Point =>
    at(anchorMm[right] + frame.origin[right], anchorMm[up] + frame.origin[up]);
  if (frame.plan === undefined) drawGrid(context, width, height, scale, color);
  else drawPlan(context, frame.plan, pictureOf(frame.plan), kToothAlpha, at, scale);
  if (frame.plan !== undefined && workpiece !== undefined && plane.name === "above") {
    const cut = cutPictureOf(workpiece);
    if (cut !== undefined) drawPlan(context, frame.plan, cut.picture, 1, at, scale);
    drawTarget(context, workpiece.target, at, scale);
  }
  context.strokeStyle = color("--plot-bound");
  line(context, rows.map(place));
  context.strokeStyle = color("--plot-mean");
  context.lineWidth = 2;
  line(context, rows.filter((row) => row.tick >= last.tick - kTrailSeconds * rateHz).map(place));
  drawTip(drawing, place(last), [last.forceN[right], last.forceN[up]]);
  context.fillStyle = color("--text-soft");
  context.font = "11px system-ui, sans-serif";
  context.fillText(`${sideOf(up, workpiece?.anatomy)} ↑`, 6, 14);
  const mesial = workpiece?.anatomy.mesial;
  if (mesial === undefined) return;
  context.textAlign = mesial > 0 ? "right" : "left";
  context.fillText(
    mesial > 0 ? `${say("axis.mesial")} →` : `← ${say("axis.mesial")}`,
    mesial > 0 ? width - 6 : 6,
    height - 6,
  );
}

// A tool beside the picture is drawn at its edge: it is over there.
function drawTip({ context, width, height, color }: Drawing, [x, y]: Point, force: Point): void {
  const within = (value: number, size: number) => Math.min(Math.max(value, kEdgePx), size - kEdgePx);
  const tip: Point = [within(x, width), within(y, height)];
  context.strokeStyle = context.fillStyle = color("--plot-removed");
  const perNewton = Math.min(width, height) / 8;
  line(context, [tip, [tip[0] + force[0] * perNewton, tip[1] - force[1] * perNewton]]);
  context.beginPath();
  context.arc(...tip, 5, 0, 2 * Math.PI);
  context.fill();
}

type At = (x: number, y: number) => Point;

function drawPlan(
  context: CanvasRenderingContext2D,
  plan: ToothPlan,
  picture: OffscreenCanvas,
  alpha: number,
  at: At,
  scale: number,
): void {
  const [left, bottom] = at(...plan.lowMm);
  const [wide, tall] = [plan.width * plan.cellMm * scale, plan.height * plan.cellMm * scale];
  context.globalAlpha = alpha;
  context.drawImage(picture, left, bottom - tall, wide, tall);
  context.globalAlpha = 1;
}

const pictures = new WeakMap<ToothPlan, OffscreenCanvas>();
const kIvory = [0.97, 0.94, 0.87] as const;

function pictureOf(plan: ToothPlan): OffscreenCanvas {
  const known = pictures.get(plan);
  if (known !== undefined) return known;
  const made = painted(plan, (cell) => {
    const shade = plan.shade[cell]!;
    return [shade * kIvory[0], shade * kIvory[1], shade * kIvory[2], shade === 0 ? 0 : 255];
  });
  pictures.set(plan, made);
  return made;
}

type Color = readonly [number, number, number, number];

function painted({ width, height }: ToothPlan, colorOf: (cell: number) => Color): OffscreenCanvas {
  const made = new OffscreenCanvas(width, height);
  const image = new ImageData(width, height);
  for (let cell = 0; cell < width * height; ++cell) image.data.set(colorOf(cell), 4 * cell);
  made.getContext("2d")?.putImageData(image, 0, 0);
  return made;
}

interface CutPicture {
  readonly picture: OffscreenCanvas;
  readonly deepestMm: number;
}

const cutPictures = new WeakMap<Cut, CutPicture>();
// From what was just scratched to the depth of most cavities: the deeper, the darker.
const kShallow = [230, 120, 40] as const;
const kDeep = [70, 0, 50] as const;
const kDeepMm = 3;

function cutPictureOf({ plan, originMm, bursMm, cut }: Workpiece): CutPicture | undefined {
  if (cut === undefined || plan === undefined || originMm === undefined) return undefined;
  const known = cutPictures.get(cut);
  if (known !== undefined) return known;
  const depth = depthsOf(plan, cut, originMm, bursMm);
  const picture = painted(plan, (cell) => {
    const share = Math.min(1, depth[cell]! / kDeepMm);
    const mix = (i: Axis) => kShallow[i] + share * (kDeep[i] - kShallow[i]);
    return [mix(0), mix(1), mix(2), depth[cell] === 0 ? 0 : 150 + 80 * share];
  });
  const made = { picture, deepestMm: depth.reduce((deepest, mm) => Math.max(deepest, mm), 0) };
  cutPictures.set(cut, made);
  return made;
}

// In words, for whoever sees no picture: empty where nothing was cut, or it is not known.
export function cutText(workpiece: Workpiece | undefined): string {
  const { deepestMm = 0 } = (workpiece && cutPictureOf(workpiece)) ?? {};
  return deepestMm === 0 ? "" : say("live.deepest", { depth: formatQuantity(deepestMm, "mm") });
}

// What the exercise asks for, from above: its outline is drawn with y downwards, as a canvas has it.
function drawTarget(context: CanvasRenderingContext2D, target: Target, at: At, scale: number): void {
  const middle = target.landmark_um;
  if (middle === undefined || middle === null) return;
  const [x, y] = at(middle[0]! / 1000, middle[1]! / 1000);
  context.save();
  context.translate(x, y);
  context.scale(scale / 1000, scale / 1000);
  context.strokeStyle = kTargetColor;
  context.lineWidth = (1.5 * 1000) / scale;
  for (const { d } of outlinePaths(target)) context.stroke(new Path2D(d));
  context.restore();
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
