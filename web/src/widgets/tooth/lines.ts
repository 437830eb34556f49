export type PointMm = readonly [number, number, number];

// Ways through the picture of a tooth, drawn over it.
export interface ToothLines {
  readonly solid: readonly (readonly PointMm[])[];
  readonly faint: readonly (readonly PointMm[])[]; // dashed
}
