import type { Result } from "../base/result";
import { Broken, checkMagic, fromPlanes, type Grid, inflate, readGrid, reading, sectionsOf, unzigzag } from "./packed";

// Reads how far the tooth at its end lies from the reference's: "ENTD", version 1
// (schemas/surface_timeline.md).

const kBrickCells = 512;
const kMaskBytes = kBrickCells / 8;
const kBrickBytes = 4 + kMaskBytes;
export const kNotCompared = -(2 ** 31);

export interface ToothDeviation {
  readonly grid: Grid;
  readonly values: number;
  // By brick, µm of each of its 512 cells; plus: more removed than in the reference; kNotCompared:
  // neither was cut there.
  readonly bricks: ReadonlyMap<number, Int32Array>;
}

export function decodeDeviation(file: ArrayBuffer): Promise<Result<ToothDeviation, string>> {
  return reading(async () => {
    const view = new DataView(file);
    checkMagic(view, "ENTD", "deviation");
    const grid = readGrid(view);
    const [count, values] = [view.getUint32(48, true), view.getUint32(52, true)];
    const gridBricks = grid.bricks[0] * grid.bricks[1] * grid.bricks[2];
    if (count > gridBricks || values > count * kBrickCells)
      throw new Broken("the deviation has more bricks or values than the grid");
    const [packedCells, packedValues] = sectionsOf(new Uint8Array(file), 56, 2, "the deviation");
    const cells = await inflate(packedCells!, count * kBrickBytes, "cells");
    const planes = await inflate(packedValues!, 4 * values, "deviation");
    return { grid, values, bricks: bricksOf(cells, planes, values, gridBricks) };
  });
}

function bricksOf(
  cells: Uint8Array<ArrayBuffer>,
  planes: Uint8Array,
  values: number,
  gridBricks: number,
): Map<number, Int32Array> {
  const view = new DataView(cells.buffer);
  const out = new Map<number, Int32Array>();
  let before = -1;
  let next = 0;
  let um = 0;
  for (let from = 0; from < cells.length; from += kBrickBytes) {
    const brick = view.getUint32(from, true);
    if (brick <= before || brick >= gridBricks)
      throw new Broken(`brick ${brick} of the deviation is out of order or outside the grid`);
    before = brick;
    const own = new Int32Array(kBrickCells).fill(kNotCompared);
    for (let i = 0; i < kBrickCells; ++i) {
      if (!((cells[from + 4 + (i >> 3)]! >> (i & 7)) & 1)) continue;
      if (next >= values) throw new Broken("the deviation names more cells than it has values");
      um = (um + unzigzag(fromPlanes(planes, 0, values, next++))) | 0;
      own[i] = um;
    }
    out.set(brick, own);
  }
  if (next !== values) throw new Broken(`the deviation has ${values} values for ${next} cells`);
  return out;
}
