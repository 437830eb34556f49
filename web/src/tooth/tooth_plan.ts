import type { Axis, Plane, ToothPlan } from "./messages";
import type { Surface } from "./surface";

// A tooth seen straight along an axis of its scene, as a picture of its own: made once, painted under every moment of
// a track. Triangles by a depth buffer of few cells; no graphics card is asked.

const kCells = 160; // of the longer side, which a card shows on 130 pixels
const kTallest = 1.2; // of the width: a side view shows the crown, where the work is, and not the roots
const kDarkest = 70;
// Where the light comes from: right, up, towards the eye. About the lamp over a dental chair.
const kLight = [-0.37, 0.46, 0.81] as const;

type Triple = readonly [number, number, number];

export function toothPlan(
  { positionMm, normal, triangle }: Surface,
  { right, up, against = [false, false] }: Plane,
): ToothPlan {
  const eye = (3 - right - up) as Axis;
  // Right, up and towards the eye are right-handed.
  const towards = (up - right + 3) % 3 === 1 ? 1 : -1;
  const [alongRight, alongUp] = [against[0] ? -1 : 1, against[1] ? -1 : 1];
  const axes: Triple = [right, up, eye];
  const signs: Triple = [alongRight, alongUp, alongRight * alongUp * towards];
  const at = (vertex: number): Triple => [
    signs[0] * positionMm[3 * vertex + right]!,
    signs[1] * positionMm[3 * vertex + up]!,
    signs[2] * positionMm[3 * vertex + eye]!,
  ];
  const { low, high } = extentOf(at, positionMm.length / 3);
  const [wide, tall] = [high[0] - low[0], Math.min(high[1] - low[1], kTallest * (high[0] - low[0]))];
  const cellMm = Math.max(wide, tall, 1e-6) / kCells;
  const width = Math.floor(wide / cellMm) + 1;
  const height = Math.floor(tall / cellMm) + 1;
  const bottom = high[1] - tall;
  const shade = new Uint8Array(width * height);
  const frontMm = new Float32Array(width * height).fill(-Infinity);
  const light = (vertex: number) => {
    const along = axes.reduce((sum, axis, i) => sum + normal[4 * vertex + axis]! * signs[i]! * kLight[i]!, 0) / 127;
    return kDarkest + (255 - kDarkest) * Math.max(0, along);
  };
  const inCells = (vertex: number): Triple => {
    const [x, y, z] = at(vertex);
    return [(x - low[0]) / cellMm, (y - bottom) / cellMm, z];
  };
  for (let t = 0; t < triangle.length; t += 3) {
    const corners = [triangle[t]!, triangle[t + 1]!, triangle[t + 2]!] as const;
    fill(corners.map(inCells) as unknown as readonly [Triple, Triple, Triple], (x, y, z, [u, v, w]) => {
      if (x < 0 || x >= width || y < 0 || y >= height) return;
      const cell = (height - 1 - y) * width + x;
      if (z <= frontMm[cell]!) return;
      frontMm[cell] = z;
      shade[cell] = Math.max(1, Math.round(u * light(corners[0]) + v * light(corners[1]) + w * light(corners[2])));
    });
  }
  return { shade, frontMm, width, height, cellMm, lowMm: [low[0], bottom] };
}

function extentOf(at: (vertex: number) => Triple, count: number) {
  const low: [number, number] = [Infinity, Infinity];
  const high: [number, number] = [-Infinity, -Infinity];
  for (let vertex = 0; vertex < count; ++vertex) {
    const place = at(vertex);
    for (const i of [0, 1] as const) {
      low[i] = Math.min(low[i], place[i]);
      high[i] = Math.max(high[i], place[i]);
    }
  }
  return { low, high };
}

// Each cell whose middle lies in the triangle, with the weights of its corners.
function fill(
  [a, b, c]: readonly [Triple, Triple, Triple],
  cell: (x: number, y: number, z: number, weights: Triple) => void,
): void {
  const area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
  if (area === 0) return;
  const [top, bottom] = [Math.max(a[1], b[1], c[1]), Math.min(a[1], b[1], c[1])];
  const [left, right] = [Math.min(a[0], b[0], c[0]), Math.max(a[0], b[0], c[0])];
  for (let y = Math.ceil(bottom - 0.5); y + 0.5 <= top; ++y) {
    for (let x = Math.ceil(left - 0.5); x + 0.5 <= right; ++x) {
      const [px, py] = [x + 0.5, y + 0.5];
      const v = ((px - a[0]) * (c[1] - a[1]) - (py - a[1]) * (c[0] - a[0])) / area;
      const w = ((b[0] - a[0]) * (py - a[1]) - (b[1] - a[1]) * (px - a[0])) / area;
      const u = 1 - v - w;
      if (u < 0 || v < 0 || w < 0) continue;
      cell(x, y, u * a[2] + v * b[2] + w * c[2], [u, v, w]);
    }
  }
}
