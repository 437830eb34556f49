import { ok, type Result } from "../base/result";
import { glbOf } from "./glb";
import { decodeInterior, tissuesIn } from "./interior";
import type { Plane, ToothPlan } from "./messages";
import { CutFill } from "./scene/cut_fill";
import type { Gl } from "./scene/gl";
import { Looks } from "./scene/looks";
import type { BlockMesh } from "./mesher";
import { stlOf } from "./stl";
import { decodeSurface } from "./surface";
import { toothPlan } from "./tooth_plan";

// What few pictures need: a script of its own with all that it uses (scripts/build.mjs). The worker loads it when a
// tooth is first cut open, seen in a plan or saved.

export const savers = { stl: stlOf, glb: glbOf };

export interface Opened {
  readonly tissues: readonly number[]; // all that are in it
  fill(gl: Gl): CutFill; // for one picture
  looksOf(mesh: BlockMesh): Uint8Array<ArrayBuffer>; // what shines through it (scene/looks.ts)
}

// `bytes`: of the start tooth.
export async function opened(bytes: ArrayBuffer): Promise<Result<Opened, string>> {
  const interior = await decodeInterior(bytes);
  if (!interior.ok) return interior;
  const { value } = interior;
  const looks = new Looks(value);
  return ok({ tissues: tissuesIn(value), fill: (gl) => new CutFill(gl, value), looksOf: (mesh) => looks.of(mesh) });
}

// `bytes`: of a surface.
export function plansOf(bytes: ArrayBuffer, planes: readonly Plane[]): Result<readonly ToothPlan[], string> {
  const surface = decodeSurface(bytes);
  return surface.ok ? ok(planes.map((plane) => toothPlan(surface.value, plane))) : surface;
}
