import { type Json, valueAt } from "../../base/document";

export const kMaxOthers = 7; // beside the first: schemas/exercise.schema.json
const kFirstRadius_um = 500;
const kStep_um = 100;

// A round bur of a size that none of these has: each shape may be there once.
export function freshBur(burs: readonly Json[]): Json {
  const taken = new Set(
    burs.filter((bur) => valueAt(bur, ["shape"]) === "sphere").map((bur) => valueAt(bur, ["radius_um"])),
  );
  let radius_um = kFirstRadius_um;
  while (taken.has(radius_um)) radius_um += kStep_um;
  return { shape: "sphere", radius_um, length_um: 0 };
}
