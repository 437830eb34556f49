import { type Anatomy, toScene } from "../../api/tooth_number";
import { formatNumber } from "../../base/format";
import type { PointMm, ScreenTold } from "../../tooth/messages";

// What lies over the picture of a tooth, put in its place whenever that was drawn.

export type Drawn = Extract<ScreenTold, { told: "drawn" }>;
type Side = "mesial" | "distal" | "buccal" | "lingual";

// Mesial, buccal, occlusal.
export const kDirections: ReadonlyArray<readonly [Side, PointMm]> = [
  ["mesial", [1, 0, 0]],
  ["distal", [-1, 0, 0]],
  ["buccal", [0, 1, 0]],
  ["lingual", [0, -1, 0]],
];
const kLabelMarginPx = [38, 18] as const; // half a label and a little air
const kAxesPx = { right: 170, top: 56 }; // from the left and the bottom of the picture
const kPinPx = 30; // with the outline of a chosen one
const kBesideTooth = 1.05; // of the radius of the ball around it
const kLabelMinShare = 0.12; // of the picture's height: shorter points at the viewer
const kAxisMm = 0.5; // short, so that perspective does not bend the axes
const kNameAt = 1.35; // of an axis
const kScaleMostPx = 96;
const kScaleMm = [0.1, 0.2, 0.5, 1, 2, 5, 10, 20] as const;

// What lies over the picture.
export function place(
  element: HTMLElement,
  { projection, extent, detail, middle }: Drawn,
  anatomy: Anatomy | undefined,
): void {
  const [width, height] = [element.clientWidth, element.clientHeight];
  const project = (point: PointMm): PointMm => {
    const [x, y, z, w] = [0, 1, 2, 3].map(
      (row) =>
        projection[row]! * point[0] +
        projection[4 + row]! * point[1] +
        projection[8 + row]! * point[2] +
        projection[12 + row]!,
    ) as [number, number, number, number];
    return [((x / w + 1) / 2) * width, ((1 - y / w) / 2) * height, z / w];
  };
  const labels = [...element.querySelectorAll<HTMLElement>(".tooth-direction")];
  placeLabels(labels, [width, height], toolsOver(element), anatomy, project, extent.centreMm, extent.radiusMm);
  placePins(element, [width, height], project);
  placeAxes(element, anatomy, project, extent.centreMm);
  placeScale(element, pxPerMm(projection, middle, width));
  element.dataset["tooth"] = detail;
}

type Box = Pick<DOMRect, "left" | "right" | "top" | "bottom">;

// The buttons and the name that lie over the picture, in its pixels.
function toolsOver(element: HTMLElement): Box[] {
  const tools =
    element.closest(".tooth")?.querySelectorAll(".tooth-tools :is(.button, select, .segmented), .tooth-name") ?? [];
  const frame = element.getBoundingClientRect();
  return [...tools]
    .map((tool) => tool.getBoundingClientRect())
    .filter((box) => box.top < frame.bottom && box.bottom > frame.top)
    .map(({ left, right, top, bottom }) => ({
      left: left - frame.left,
      right: right - frame.left,
      top: top - frame.top,
      bottom: bottom - frame.top,
    }));
}

// From the left, where a label is hidden by none of the boxes: moved towards the middle of the picture, from a box that
// is there to the nearer side.
export function clearOf(boxes: readonly Box[], left: number, top: number, width: number): number {
  const [across, down] = kLabelMarginPx;
  return boxes.reduce((at, box) => {
    if (Math.abs(top - (box.top + box.bottom) / 2) > (box.bottom - box.top) / 2 + down) return at;
    if (at + across < box.left || at - across > box.right) return at;
    const isInMiddle = box.left < width / 2 && box.right > width / 2;
    const goesRight = isInMiddle ? 2 * at > box.left + box.right : box.left + box.right < width;
    return goesRight ? Math.max(at, box.right + across) : Math.min(at, box.left - across);
  }, left);
}

// Names of the sides at the edge of the picture, in the direction in which they lie; hidden where
// they lie towards the viewer or away.
function placeLabels(
  labels: readonly HTMLElement[],
  [width, height]: readonly [number, number],
  tools: readonly Box[],
  anatomy: Anatomy | undefined,
  project: (point: PointMm) => PointMm,
  centre: PointMm,
  radius: number,
): void {
  const [cx, cy] = project(centre);
  kDirections.forEach(([, direction], i) => {
    const label = labels[i];
    if (label === undefined) return;
    const [x, y, z] = anatomy === undefined ? [0, 0, 0] : toScene(anatomy, direction);
    const at = project([centre[0] + x * radius, centre[1] + y * radius, centre[2] + z * radius]);
    const [dx, dy] = [at[0] - cx, at[1] - cy];
    const half = [width / 2, height / 2] as const;
    // At the edge of the picture, or beside the tooth where that is nearer.
    const toEdge = Math.min(
      kBesideTooth,
      (half[0] - kLabelMarginPx[0]) / Math.abs(dx),
      (half[1] - kLabelMarginPx[1]) / Math.abs(dy),
    );
    const visible = Math.hypot(dx, dy) > kLabelMinShare * height && Number.isFinite(toEdge);
    label.style.visibility = visible ? "visible" : "hidden";
    if (!visible) return;
    const [left, top] = [half[0] + dx * toEdge, half[1] + dy * toEdge];
    const aboveAxes = height - kAxesPx.top - kLabelMarginPx[1];
    const shown = left < kAxesPx.right + kLabelMarginPx[0] ? Math.min(top, aboveAxes) : top;
    const clear = clearOf(tools, left, shown, width);
    label.style.transform = `translate(-50%, -50%) translate(${clear}px, ${shown}px)`;
  });
}

// Which way mesial, buccal and occlusal point in the picture, in a corner of it.
export const kAxes: ReadonlyArray<readonly ["mesial" | "buccal" | "occlusal", PointMm]> = [
  ["mesial", [1, 0, 0]],
  ["buccal", [0, 1, 0]],
  ["occlusal", [0, 0, 1]],
];

// Ends of the axes, to the right and down; the longest has the length 1.
export function axisEnds(
  anatomy: Anatomy,
  project: (point: PointMm) => PointMm,
  centre: PointMm,
): ReadonlyArray<readonly [number, number]> {
  const [cx, cy] = project(centre);
  const ends = kAxes.map(([, direction]) => {
    const [x, y, z] = toScene(anatomy, direction);
    const at = project([centre[0] + x * kAxisMm, centre[1] + y * kAxisMm, centre[2] + z * kAxisMm]);
    return [at[0] - cx, at[1] - cy] as const;
  });
  const longest = Math.max(...ends.map(([x, y]) => Math.hypot(x, y))) || 1;
  return ends.map(([x, y]) => [x / longest, y / longest]);
}

function placeAxes(
  frame: HTMLElement,
  anatomy: Anatomy | undefined,
  project: (point: PointMm) => PointMm,
  centre: PointMm,
): void {
  const axes = frame.querySelector<SVGElement>(".tooth-axes");
  if (axes === null) return;
  axes.style.visibility = anatomy === undefined ? "hidden" : "visible";
  if (anatomy === undefined) return;
  const lines = axes.querySelectorAll("line");
  const names = axes.querySelectorAll("text");
  axisEnds(anatomy, project, centre).forEach(([x, y], i) => {
    lines[i]?.setAttribute("x2", x.toFixed(3));
    lines[i]?.setAttribute("y2", y.toFixed(3));
    names[i]?.setAttribute("x", (kNameAt * x).toFixed(3));
    names[i]?.setAttribute("y", (kNameAt * y).toFixed(3));
  });
}

// Whole at the edge of the picture, and not beyond it.
function placePins(
  frame: HTMLElement,
  [width, height]: readonly [number, number],
  project: (point: PointMm) => PointMm,
): void {
  for (const pin of frame.querySelectorAll<HTMLElement>(".tooth-pin")) {
    const [x = 0, y = 0, z = 0] = (pin.dataset["point"] ?? "").split(" ").map(Number);
    const [left, top] = project([x, y, z]);
    const kept = (at: number, size: number) => Math.min(Math.max(at, kPinPx / 2), size - kPinPx / 2).toFixed(1);
    pin.style.visibility = left >= 0 && left <= width && top >= 0 && top <= height ? "" : "hidden";
    pin.style.transform = `translate(-50%, -50%) translate(${kept(left, width)}px, ${kept(top, height)}px)`;
  }
}

// The longest length of a usual size that is not too wide.
function placeScale(frame: HTMLElement, perMm: number): void {
  const scale = frame.querySelector<HTMLElement>(".tooth-scale");
  if (scale === null) return;
  const mm = kScaleMm.filter((length) => length * perMm <= kScaleMostPx).at(-1) ?? kScaleMm[0];
  scale.style.width = `${(mm * perMm).toFixed(1)}px`;
  const text = `${formatNumber(mm, 1)}\u00a0mm`; // short, as it stands in it
  if (scale.textContent !== text) scale.textContent = text; // or it would be laid out again
}

// Across the picture, at a point of the scene. The columns of `m` lead from the scene to −1 … 1.
export function pxPerMm(m: readonly number[], [x, y, z]: PointMm, widthPx: number): number {
  const row = (i: number) => [m[i]!, m[4 + i]!, m[8 + i]!] as const;
  const at = (i: number) => row(i)[0] * x + row(i)[1] * y + row(i)[2] * z + m[12 + i]!;
  const [w, right] = [at(3), at(0) / at(3)];
  const [across, away] = [row(0), row(3)];
  return (Math.hypot(...across.map((value, axis) => value - right * away[axis]!)) / w) * (widthPx / 2);
}
