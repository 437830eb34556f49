import { brickAt, bricksNear, type Interior, voxelAt } from "../interior";
import type { BlockMesh } from "../mesher";
import { kLesionColors, kTissues, tissueColor } from "../tissue_color";
import { linearColor, type Rgb } from "./colors";
import { add, cross, dot, scaled, sub, unit, type Vec } from "./vec";

// What shines through a tooth's surface, as at the chair: the figures are those of station/render/tooth_looks.cpp, which
// has their sources. Enamel lets through dentin, a lesion and, where it grew so, the dark of the mouth; dentin the pulp
// and a lesion; a lesion's border is soft.

const [kAir, kEnamel, kDentin, kPulp, kCaries] = [0, 1, 2, 3, 4] as const;
export const kFigures = {
  kThickestEnamel: 3, // mm
  kThickestDentin: 1.2,
  kStep: 0.2,
  kLesionReach: 0.35,
  kAslant: 0.5, // sine of four ways inward; the fifth goes straight
  kBehind: -0.4, // cosine of both faces of an edge
  kPower: 2.6, // of the wavelength
} as const;
const { kThickestEnamel, kThickestDentin, kStep, kLesionReach, kAslant, kBehind, kPower } = kFigures;
// Scattered per mm, and the share of it that goes on.
export const kScattered = { enamel: [6.6, 0.68], dentin: [27, 0.93] } as const;
const exchanged = ([perMm, forward]: readonly [number, number]) => 0.75 * perMm * (1 - forward);
const [kEnamelPerMm, kDentinPerMm] = [exchanged(kScattered.enamel), exchanged(kScattered.dentin)];
const kBall = 48; // places around a vertex

const passesTwice = (perMm: number, mm: number) => 1 / (1 + perMm * mm) ** 2;
export const throughEnamel = (mm: number) => passesTwice(kEnamelPerMm, mm);
const kByColor = [612, 549, 465].map((nm) => (550 / nm) ** kPower) as unknown as Rgb;
export const overDark = (mm: number): Rgb =>
  kByColor.map((share) => 1 - 1 / (1 + kEnamelPerMm * mm * share)) as unknown as Rgb;

const kLinear = Array.from({ length: kTissues }, (_, tissue) => linearColor(tissueColor(tissue)));
const [kChalk, kSoft] = kLesionColors.map(linearColor) as [Rgb, Rgb];

const mixed = (a: Rgb, b: Rgb, share: number): Rgb => add(scaled(a, 1 - share), scaled(b, share));
function ramp(value: number, low: number, high: number): number {
  const share = Math.min(1, Math.max(0, (value - low) / (high - low)));
  return share * share * (3 - 2 * share);
}

// Even in depth and direction.
const kBallPlaces: readonly Vec[] = Array.from({ length: kBall }, (_, i) => {
  const z = 1 - (2 * (i + 0.5)) / kBall;
  const turn = 2 * Math.PI * 0.6180339887498949 * i;
  const ring = Math.sqrt(1 - z * z);
  const radius = Math.cbrt(((i + 0.5) * 0.7548776662466927) % 1);
  return scaled([ring * Math.cos(turn), ring * Math.sin(turn), z], radius * kLesionReach);
});

interface Ground {
  readonly tissue: number; // the layer's own: it does not end
  readonly mm: number; // below the surface
  readonly place: Vec;
}

export class Looks {
  private readonly nearCaries: Uint8Array; // of each brick

  constructor(private readonly interior: Interior) {
    this.nearCaries = bricksNear(interior, kCaries, kLesionReach);
  }

  // Four bytes of each vertex: the square roots of its linear colour, and 255 where it is known.
  of({ positionMm: p, normal, tissue, cut }: BlockMesh): Uint8Array<ArrayBuffer> {
    const out = new Uint8Array(4 * tissue.length);
    const { voxelMm } = this.interior.grid;
    tissue.forEach((own, i) => {
      if (own !== kEnamel && own !== kDentin && own !== kCaries) return;
      const n: Vec = unit([normal[4 * i]!, normal[4 * i + 1]!, normal[4 * i + 2]!]);
      const at = sub([p[3 * i]!, p[3 * i + 1]!, p[3 * i + 2]!], scaled(n, voxelMm));
      const sound = own === kEnamel ? this.enamel(at, n, cut?.[i] !== 1) : this.dentin(at, n, own);
      const color = this.lesion(at, own, sound);
      for (let k = 0; k < 3; ++k) out[4 * i + k] = Math.round(255 * Math.sqrt(color[k]!));
      out[4 * i + 3] = 255;
    });
    return out;
  }

  private enamel(at: Vec, n: Vec, uncut: boolean): Rgb {
    const thick = kLinear[kEnamel]!;
    return this.mean(kEnamel, at, n, kThickestEnamel, ({ tissue, mm, place }) => {
      if (tissue === kDentin || tissue === kCaries) return mixed(thick, kLinear[tissue]!, throughEnamel(mm));
      if (tissue !== kAir || !uncut || dot(this.outward(place), n) > kBehind) return thick;
      const back = overDark(mm);
      return [thick[0] * back[0], thick[1] * back[1], thick[2] * back[2]];
    });
  }
  private dentin(at: Vec, n: Vec, own: number): Rgb {
    const thick = kLinear[own]!;
    if (own !== kDentin) return thick;
    return this.mean(kDentin, at, n, kThickestDentin, ({ tissue, mm }) =>
      tissue === kPulp || tissue === kCaries ? mixed(thick, kLinear[tissue]!, passesTwice(kDentinPerMm, mm)) : thick,
    );
  }
  private lesion(at: Vec, own: number, sound: Rgb): Rgb {
    if (this.nearCaries[brickAt(this.interior, ...at)] !== 1) return sound;
    let [caries, all] = [0, 0];
    for (const place of kBallPlaces) {
      const there = this.tissue(add(at, place));
      if (there !== kAir) ++all;
      if (there === kCaries) ++caries;
    }
    const share = all === 0 ? 0 : caries / all;
    let color = mixed(sound, own === kEnamel ? kChalk : kSoft, ramp(share, 0.05, 0.4));
    color = mixed(color, kSoft, ramp(share, 0.35, 0.8));
    return mixed(color, kLinear[kCaries]!, ramp(share, 0.65, 1));
  }

  private tissue([x, y, z]: Vec): number {
    return voxelAt(this.interior, x, y, z);
  }
  // Where the air is around a place of the surface; length 1. Of the voxels two away in all directions: those beside it
  // would know but a few directions.
  private outward(place: Vec): Vec {
    const reach = 2 * this.interior.grid.voxelMm;
    let out: Vec = [0, 0, 0];
    for (const x of [-1, 0, 1])
      for (const y of [-1, 0, 1])
        for (const z of [-1, 0, 1])
          if (this.tissue(add(place, scaled([x, y, z], reach))) === kAir) out = add(out, [x, y, z]);
    return unit(out);
  }
  // Of the colours of what is below, over ways inward.
  private mean(own: number, at: Vec, n: Vec, limitMm: number, color: (ground: Ground) => Rgb): Rgb {
    const u = unit(cross(n, Math.abs(n[0]) < 0.7 ? [1, 0, 0] : [0, 1, 0]));
    const v = cross(n, u);
    const straight = scaled(n, -Math.sqrt(1 - kAslant * kAslant));
    let sum: Rgb = color(this.ground(own, at, scaled(n, -1), limitMm));
    for (const aside of [u, v, scaled(u, -1), scaled(v, -1)])
      sum = add(sum, color(this.ground(own, at, add(scaled(aside, kAslant), straight), limitMm)));
    return scaled(sum, 1 / 5);
  }
  private ground(own: number, at: Vec, way: Vec, limitMm: number): Ground {
    const along = (mm: number): Vec => add(at, scaled(way, mm));
    for (let end: number = kStep; end <= limitMm + 1e-9; end += kStep) {
      const tissue = this.tissue(along(end));
      if (tissue === own) continue;
      let [from, to] = [end - kStep, end];
      for (let i = 0; i < 4; ++i) {
        const middle = (from + to) / 2;
        if (this.tissue(along(middle)) === own) from = middle;
        else to = middle;
      }
      return { tissue, mm: this.interior.grid.voxelMm + to, place: along(to) };
    }
    return { tissue: own, mm: limitMm, place: along(limitMm) };
  }
}
