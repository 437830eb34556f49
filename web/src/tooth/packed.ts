import { fail, ok, type Result } from "../base/result";

// What the files of a playback have in common (schemas/surface_timeline.md): packed parts, the way
// they begin, their grid.

type Read<T> = Result<T, string>;

const kMaxRatio = 1032; // of what a packed byte can stand for
const kMaxBricks = 8_000_000;
export const kFormatBytes = 48; // letters, version and grid

export interface Grid {
  readonly voxelMm: number;
  readonly bricks: readonly [number, number, number];
  readonly originMm: readonly [number, number, number];
}

export class Broken extends Error {}

// `read` may throw Broken, which becomes the result's error; anything else is a bug and is thrown
// on.
export async function reading<T>(read: () => Promise<T> | T): Promise<Read<T>> {
  try {
    return ok(await read());
  } catch (error) {
    if (error instanceof Broken || error instanceof RangeError) return fail(error.message);
    throw error;
  }
}

// Exactly `size` bytes; no memory is taken for a size that these bytes cannot give.
export async function inflate(
  packed: Uint8Array<ArrayBuffer>,
  size: number,
  what: string,
): Promise<Uint8Array<ArrayBuffer>> {
  if (size > (packed.length + 1) * kMaxRatio)
    throw new Broken(`${what}: ${packed.length} packed bytes cannot hold the ${size} that the head asks for`);
  const out = new Uint8Array(size);
  const damaged = () => new Broken(`${what}: expected ${size} bytes, found others or damaged ones`);
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate")).getReader();
  let at = 0;
  for (;;) {
    const { done, value } = await stream.read().catch(() => {
      throw damaged();
    });
    if (done) break;
    if (at + value.length > size) {
      void stream.cancel();
      throw damaged();
    }
    out.set(value, at);
    at += value.length;
  }
  if (at !== size) throw damaged();
  return out;
}

// All are version 1.
export function checkMagic(view: DataView, magic: string, what: string): void {
  if (view.byteLength < kFormatBytes) throw new Broken(`${what}: expected more than ${view.byteLength} bytes`);
  const found = String.fromCharCode(view.getUint8(0), view.getUint8(1), view.getUint8(2), view.getUint8(3));
  if (found !== magic) throw new Broken(`${what} begins with ${magic}, found something else`);
  const version = view.getUint16(4, true);
  if (version !== 1)
    throw new Broken(`this page reads version 1 of a ${what}, found version ${version}; load the page again`);
  if (view.getUint16(6, true) !== 0) throw new Broken(`${what}: expected flags 0, found others`);
}

export function readGrid(view: DataView): Grid {
  const bricks = [view.getInt32(12, true), view.getInt32(16, true), view.getInt32(20, true)] as const;
  const voxelNm = view.getInt32(8, true);
  const count = bricks[0] * bricks[1] * bricks[2];
  if (voxelNm < 5000 || voxelNm > 1_000_000 || bricks.some((n) => n < 1 || n > 4096) || count > kMaxBricks) {
    throw new Broken(`the grid is none that this page draws (${bricks.join(" × ")} bricks of ${voxelNm} nm)`);
  }
  const origin = (i: number) => Number(view.getBigInt64(24 + 8 * i, true)) * 1e-6;
  return { voxelMm: voxelNm * 1e-6, bricks, originMm: [origin(0), origin(1), origin(2)] };
}

// Value `i` of `n`: four planes from `at` on, of small differences of either sign.
export function fromPlanes(raw: Uint8Array, at: number, n: number, i: number): number {
  return (raw[at + i]! | (raw[at + n + i]! << 8) | (raw[at + 2 * n + i]! << 16) | (raw[at + 3 * n + i]! << 24)) >>> 0;
}
export const unzigzag = (value: number) => (value >>> 1) ^ -(value & 1);

// `count` packed parts of `bytes` from `at` on, each after its length; nothing follows the last.
export function sectionsOf(
  bytes: Uint8Array<ArrayBuffer>,
  at: number,
  count: number,
  what: string,
): Uint8Array<ArrayBuffer>[] {
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.length);
  const out: Uint8Array<ArrayBuffer>[] = [];
  for (let i = 0; i < count; ++i) {
    if (at + 4 > bytes.length || at + 4 + view.getUint32(at, true) > bytes.length)
      throw new Broken(`${what} ends early`);
    const end = at + 4 + view.getUint32(at, true);
    out.push(bytes.subarray(at + 4, end));
    at = end;
  }
  if (at !== bytes.length) throw new Broken(`${what} has ${bytes.length - at} bytes too many`);
  return out;
}
