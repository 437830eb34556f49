import { type Box3, BufferAttribute, BufferGeometry, LineBasicMaterial, LineSegments, Plane, Vector3 } from "three";
import { crossings } from "./plane_cut";

// A plane that hides what is in front of it, and the line along which it cuts the tooth.

export interface SectionPlane {
  readonly across: "x" | "y" | "z" | "view"; // what the plane stands across: an axis of the scene, or the line of sight
  readonly share: number; // −1 … 1 of the tooth's radius from its middle
  readonly flipped: boolean; // hides the other side
}

export interface Cuttable {
  readonly mesh: { readonly positionMm: Float32Array; readonly triangle: Uint32Array | Uint16Array };
  readonly box: Box3;
}

const kAxes = { x: new Vector3(1, 0, 0), y: new Vector3(0, 1, 0), z: new Vector3(0, 0, 1) } as const;

export class Section {
  readonly plane = new Plane(); // what lies behind it, against its normal, is hidden
  readonly outline: LineSegments<BufferGeometry, LineBasicMaterial>;
  private plan: SectionPlane | undefined;
  private stale = false;

  constructor(color = "#8c1d18") {
    this.outline = new LineSegments(
      new BufferGeometry(),
      new LineBasicMaterial({ color, depthTest: false, transparent: true }),
    );
    this.outline.renderOrder = 4;
    this.outline.frustumCulled = false;
    this.outline.visible = false;
  }
  dispose(): void {
    this.outline.geometry.dispose();
    this.outline.material.dispose();
  }

  get wanted(): SectionPlane | undefined {
    return this.plan;
  }
  get on(): boolean {
    return this.plan !== undefined;
  }
  set(wanted: SectionPlane | undefined): void {
    this.plan = wanted;
    this.outline.visible = wanted !== undefined;
    this.stale = true;
  }
  // What is cut has changed.
  changed(): void {
    this.stale = true;
  }

  // Before each picture. `sight`: from the target to the camera.
  update(centre: Vector3, radius: number, sight: Vector3, parts: () => Iterable<Cuttable>): void {
    if (this.plan === undefined) return;
    const { across, share, flipped } = this.plan;
    // What is nearer to the viewer goes.
    const normal = across === "view" ? sight.clone().negate().normalize() : kAxes[across].clone();
    if (flipped) normal.negate();
    const through = centre.clone().addScaledVector(normal, (flipped ? -1 : 1) * share * radius);
    const before = this.plane.clone();
    this.plane.setFromNormalAndCoplanarPoint(normal, through);
    if (!this.stale && this.plane.equals(before)) return;
    this.stale = false;
    this.draw(parts());
  }

  private draw(parts: Iterable<Cuttable>): void {
    const { normal, constant } = this.plane;
    const lines: number[] = [];
    for (const { mesh, box } of parts) {
      if (box.intersectsPlane(this.plane)) crossings(mesh.positionMm, mesh.triangle, normal.toArray(), constant, lines);
    }
    this.outline.geometry.dispose();
    this.outline.geometry = new BufferGeometry();
    this.outline.geometry.setAttribute("position", new BufferAttribute(new Float32Array(lines), 3));
  }
}
