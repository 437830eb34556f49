import { ok, type Result } from "../base/result";
import { decodeInterior, tissuesIn } from "./interior";
import { CutFill } from "./scene/cut_fill";
import type { Gl } from "./scene/gl";

// A tooth whose inside is known. A script of its own with all that it needs (scripts/build.mjs): the worker loads it when
// a tooth is first cut open.

export interface Opened {
  readonly tissues: readonly number[]; // all that are in it
  fill(gl: Gl): CutFill; // for one picture
}

// `bytes`: of the start tooth.
export async function opened(bytes: ArrayBuffer): Promise<Result<Opened, string>> {
  const interior = await decodeInterior(bytes);
  if (!interior.ok) return interior;
  const { value } = interior;
  return ok({ tissues: tissuesIn(value), fill: (gl) => new CutFill(gl, value) });
}
