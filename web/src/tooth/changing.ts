import type { Result } from "../base/result";
import { Broken, fromPlanes, type Grid, inflate, reading, sectionsOf } from "./packed";
import { bricksFromResiduals, kBrickSamples, kDeep, kFarOut } from "./samples";
import { kTissues } from "./tissue_color";

// Reads the part of a tooth that changes (schemas/surface_timeline.md, "The part that changes").

const kTissue = 7;
const kSampled = 8;
const kLabelled = 16;
export const kTriangles = 32;
const kKnown = kTissue | kSampled | kLabelled | kTriangles;

export interface Bricks {
  readonly grid: Grid;
  readonly flags: Uint8Array; // of each brick of the grid; 0 where it is not listed
  readonly samples: Int8Array; // 512 of each sampled brick
  readonly slot: Int32Array; // per brick: its place in `samples`, or −1
  readonly labels: Uint8Array;
  readonly labelSlot: Int32Array;
  readonly changing: Uint32Array; // the bricks whose triangles change
}

export function decodeChanging(bytes: Uint8Array<ArrayBuffer>, grid: Grid): Promise<Result<Bricks, string>> {
  return reading(async () => {
    const count = grid.bricks[0] * grid.bricks[1] * grid.bricks[2];
    const listed = new DataView(bytes.buffer, bytes.byteOffset, bytes.length).getUint32(0, true);
    if (listed > count) throw new Broken("the changing part has more bricks than the grid");
    const [packedBricks, packedSamples, packedLabels] = sectionsOf(bytes, 4, 3, "the changing part");
    const numbers = await inflate(packedBricks!, 5 * listed, "bricks");
    const flags = new Uint8Array(count);
    const slot = new Int32Array(count).fill(-1);
    const labelSlot = new Int32Array(count).fill(-1);
    const changing: number[] = [];
    let brick = -1;
    let sampled = 0;
    let labelled = 0;
    for (let i = 0; i < listed; ++i) {
      brick += 1 + fromPlanes(numbers, 0, listed, i);
      if (brick >= count) throw new Broken("a brick is outside the grid");
      const own = numbers[4 * listed + i]!;
      if (own & ~kKnown) throw new Broken("a brick has flags that this page does not know");
      flags[brick] = own;
      if (own & kSampled) slot[brick] = sampled++;
      if (own & kLabelled) labelSlot[brick] = labelled++;
      if (own & kTriangles) changing.push(brick);
    }
    const samples = new Int8Array((await inflate(packedSamples!, sampled * kBrickSamples, "samples")).buffer);
    const labels = await inflate(packedLabels!, labelled * kBrickSamples, "labels");
    if (labels.some((tissue) => tissue >= kTissues)) throw new Broken("a label is no tissue");
    bricksFromResiduals(samples);
    return { grid, flags, samples, slot, labels, labelSlot, changing: Uint32Array.from(changing) };
  });
}

// The part as it is before the first tick.
export class ChangingPart {
  // Of each sampled brick, made once: a view costs as much as copying what it shows.
  private readonly views: readonly Int8Array[];

  constructor(readonly bricks: Bricks) {
    const { samples } = bricks;
    this.views = Array.from({ length: samples.length / kBrickSamples }, (_, place) =>
      samples.subarray(place * kBrickSamples, (place + 1) * kBrickSamples),
    );
  }

  // Samples of a brick, or what all of them are.
  samples(brick: number): Int8Array | number {
    return this.startSamples(brick);
  }
  startSamples(brick: number): Int8Array | number {
    const { slot, flags } = this.bricks;
    const view = this.views[slot[brick]!];
    if (view !== undefined) return view;
    return (flags[brick]! & (kTissue | kLabelled)) === 0 ? kFarOut : kDeep;
  }
  tissue(brick: number, sample: number): number {
    const place = this.bricks.labelSlot[brick]!;
    return place >= 0 ? this.bricks.labels[place * kBrickSamples + sample]! : this.bricks.flags[brick]! & kTissue;
  }
}
