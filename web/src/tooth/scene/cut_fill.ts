import type { Extent } from "../places";
import { type Interior, tissueAt } from "../interior";
import { kTissues, tissueColor } from "../tissue_color";
import { parseHex } from "../deviation_scale";
import type { Plane } from "./plane_cut";
import { type Gl, kSliceUnit } from "./gl";
import { cross, dot, scaled, sub, unit, type Vec } from "./vec";

// The tissues in the plane of a section, as a texture. Where one looks through the plane at the inside of the surface, a
// pixel takes its colour from the place where its line of sight meets the plane.

// A square in the plane, around the tooth.
export interface Slice {
  readonly middle: Vec;
  readonly right: Vec; // of length 1, and so is `up`
  readonly up: Vec;
  readonly half: number; // of its side
}

export function sliceAround(plane: Plane, centre: Vec, radius: number): Slice {
  const normal: Vec = [plane[0], plane[1], plane[2]];
  const right = unit(cross(Math.abs(normal[2]) < 0.9 ? [0, 0, 1] : [1, 0, 0], normal));
  const middle = sub(centre, scaled(normal, dot(normal, centre) + plane[3]));
  return { middle, right, up: cross(normal, right), half: radius };
}

const kMaxAcross = 512; // of a slice; a tooth of 12 mm at 0.05 mm has 480 voxels along its diagonal

// RGBA, row by row from −right, −up on; transparent where there is no tissue.
export function pixelsOf(interior: Interior, { middle, right, up, half }: Slice) {
  const across = Math.min(kMaxAcross, Math.ceil((2 * half) / interior.grid.voxelMm));
  // As a little-endian number, red first.
  const colors = Array.from({ length: kTissues }, (_, tissue) => {
    const [red, green, blue] = parseHex(tissueColor(tissue));
    return ((255 << 24) | (blue << 16) | (green << 8) | red) >>> 0;
  });
  const pixels = new Uint32Array(across * across);
  for (let j = 0; j < across; ++j)
    for (let i = 0; i < across; ++i) {
      const [u, v] = [half * ((2 * i + 1) / across - 1), half * ((2 * j + 1) / across - 1)];
      const tissue = tissueAt(
        interior,
        middle[0] + u * right[0] + v * up[0],
        middle[1] + u * right[1] + v * up[1],
        middle[2] + u * right[2] + v * up[2],
      );
      if (tissue !== 0) pixels[j * across + i] = colors[tissue]!;
    }
  return { across, pixels: new Uint8Array(pixels.buffer) };
}

// From the picture's pixels (x, y, 1), counted from its lower left corner, to a slice's 0 … 1: three rows, and the third
// divides the other two. `wayThrough`: the line of sight through a place of the picture, −1 … 1.
export function rowsToSlice(
  { middle, right, up, half }: Slice,
  plane: Plane,
  eye: Vec,
  wayThrough: (right: number, up: number) => Vec,
  [width, height]: readonly [number, number],
): number[] {
  const normal: Vec = [plane[0], plane[1], plane[2]];
  const first = wayThrough(-1, -1);
  const ways = [
    scaled(sub(wayThrough(1, -1), first), 1 / width),
    scaled(sub(wayThrough(-1, 1), first), 1 / height),
    first,
  ];
  const over = dot(normal, eye) + plane[3]; // the plane is met after −over / (normal · way)
  const from = sub(eye, middle);
  const row = (axis: Vec) => {
    const begin = 0.5 + dot(axis, from) / (2 * half);
    return ways.map((way) => begin * dot(normal, way) - (over * dot(axis, way)) / (2 * half));
  };
  return [...row(right), ...row(up), ...ways.map((way) => dot(normal, way))];
}

export class CutFill {
  private readonly texture: WebGLTexture;
  private plane: Plane | undefined; // that the texture shows
  private slice: Slice = { middle: [0, 0, 0], right: [1, 0, 0], up: [0, 1, 0], half: 1 };

  constructor(
    private readonly gl: Gl,
    private readonly interior: Interior,
  ) {
    this.texture = gl.createTexture();
  }
  dispose(): void {
    this.gl.deleteTexture(this.texture);
  }

  tissueAt([x, y, z]: Vec): number | undefined {
    return tissueAt(this.interior, x, y, z) || undefined;
  }

  // Before a picture with a section. Returns what the pixels need to find their place (rowsToSlice).
  update(
    plane: Plane,
    { centreMm, radiusMm }: Extent,
    eye: Vec,
    wayThrough: (right: number, up: number) => Vec,
    size: readonly [number, number],
  ): number[] {
    if (plane !== this.plane) {
      this.plane = plane;
      this.slice = sliceAround(plane, centreMm, radiusMm);
      this.write(pixelsOf(this.interior, this.slice));
    }
    return rowsToSlice(this.slice, plane, eye, wayThrough, size);
  }
  private write({ across, pixels }: ReturnType<typeof pixelsOf>): void {
    const { gl } = this;
    gl.activeTexture(gl.TEXTURE0 + kSliceUnit);
    gl.bindTexture(gl.TEXTURE_2D, this.texture);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA, across, across, 0, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.LINEAR);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_T, gl.CLAMP_TO_EDGE);
    gl.activeTexture(gl.TEXTURE0);
  }
}
