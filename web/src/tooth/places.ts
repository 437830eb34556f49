// Millimetres, scene frame: +y buccal, +z occlusal; mesial as api/tooth_number.ts says.
export type PointMm = readonly [number, number, number];

// A ball around something.
export interface Extent {
  readonly centreMm: PointMm;
  readonly radiusMm: number;
}
