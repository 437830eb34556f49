import type { Exercise, LiveCut } from "../../api/types";
import type { ToothPlan } from "../../tooth/messages";

// Where an attempt in progress has cut: the lowest place of each bur's tip by column of the scene, in
// mm from the device's origin.
export interface Cut {
  readonly chunks: number;
  readonly columns: ReadonlyMap<string, readonly [number, number, number, number]>; // its middle, how low, the bur
}

// An answer of fewer chunks than before is of a recording that began again.
export function withColumns(cut: Cut | undefined, { chunks, cell_um: cell, columns }: LiveCut): Cut {
  const kept = cut !== undefined && cut.chunks <= chunks ? cut.columns : [];
  const middle = (number: number) => ((number + 0.5) * cell) / 1000;
  return {
    chunks,
    columns: new Map([
      ...kept,
      ...columns.map(
        ([x = 0, y = 0, low = 0, bur = 0]) => [`${x} ${y} ${bur}`, [middle(x), middle(y), low / 1000, bur]] as const,
      ),
    ]),
  };
}

const kMinMm = 0.1; // less may be the surface itself: cells and columns are as wide

// How deep it went at each cell of a plan from above, in mm below the start tooth's surface; 0: not at all.
// `originMm`: where the columns' places are counted from.
export function depthsOf(
  plan: ToothPlan,
  cut: Cut,
  [originX, originY, originZ]: readonly [number, number, number],
  bursMm: readonly number[],
): Float32Array {
  const { width, height, cellMm, lowMm, frontMm } = plan;
  const depth = new Float32Array(width * height);
  for (const [x, y, low, bur] of cut.columns.values()) {
    const radius = bursMm[bur]! / cellMm;
    const right = (x + originX - lowMm[0]) / cellMm;
    const up = height - (y + originY - lowMm[1]) / cellMm;
    for (let row = Math.max(0, Math.ceil(up - radius - 0.5)); row < height && row + 0.5 <= up + radius; ++row) {
      const reach = Math.sqrt(Math.max(0, radius ** 2 - (row + 0.5 - up) ** 2));
      for (let i = Math.max(0, Math.ceil(right - reach - 0.5)); i < width && i + 0.5 <= right + reach; ++i) {
        const cell = row * width + i;
        const deep = frontMm[cell]! - (low + originZ);
        if (deep >= kMinMm && deep > depth[cell]!) depth[cell] = deep;
      }
    }
  }
  return depth;
}

export function burRadiiMm({ burs }: Exercise): number[] {
  return burs.map((bur) => bur.radius_um / 1000);
}
