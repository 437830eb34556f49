import { BufferGeometry, Group, LineBasicMaterial, LineDashedMaterial, LineSegments, Vector3 } from "three";
import type { PointMm, ToothLines } from "./lines";

const kColor = 0x6d28d9;
const kDashMm = 0.12;

// Lines over the tooth, as they are given.
export class LineGroup {
  readonly group = new Group();
  private readonly over = { color: kColor, depthTest: false, transparent: true };
  private readonly solid = new LineSegments(
    new BufferGeometry(),
    new LineBasicMaterial({ ...this.over, opacity: 0.9 }),
  );
  private readonly faint = new LineSegments(
    new BufferGeometry(),
    new LineDashedMaterial({ ...this.over, opacity: 0.65, dashSize: kDashMm, gapSize: kDashMm }),
  );

  constructor() {
    this.solid.renderOrder = this.faint.renderOrder = 1;
    this.group.add(this.solid, this.faint);
    this.group.visible = false;
  }

  set(lines: ToothLines | undefined): void {
    this.group.visible = lines !== undefined;
    if (lines === undefined) return;
    for (const [segments, ways] of [
      [this.solid, lines.solid],
      [this.faint, lines.faint],
    ] as const) {
      segments.geometry.dispose();
      segments.geometry = new BufferGeometry().setFromPoints(ways.flatMap(pairs));
      segments.frustumCulled = false;
    }
    this.faint.computeLineDistances();
  }

  dispose(): void {
    for (const segments of [this.solid, this.faint]) {
      segments.geometry.dispose();
      segments.material.dispose();
    }
  }
}

function pairs(way: readonly PointMm[]): Vector3[] {
  return way.slice(1).flatMap((point, i) => [new Vector3(...way[i]!), new Vector3(...point)]);
}
