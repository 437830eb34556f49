import { ConeGeometry, CylinderGeometry, Mesh, MeshBasicMaterial, Vector3 } from "three";

const kArrowMmPerN = 1.5; // as the words say (tooth.force_arrow)
const kMostMm = 12;
const kShaftMm = 0.09;
const kHeadMm = 0.55;
const kUp = new Vector3(0, 1, 0);

// The force on the hand as an arrow from the bur's tip, over the tooth.
export class ForceArrow {
  // A shaft of 1 mm that is drawn out along y, with a head at its end.
  readonly mesh: Mesh;
  private readonly head: Mesh;
  private force: readonly [number, number, number] | undefined;

  constructor() {
    const material = new MeshBasicMaterial({ color: 0xc2410c, depthTest: false, transparent: true });
    this.mesh = new Mesh(new CylinderGeometry(kShaftMm, kShaftMm, 1, 12).translate(0, 0.5, 0), material);
    this.head = new Mesh(new ConeGeometry(3 * kShaftMm, kHeadMm, 16).translate(0, kHeadMm / 2, 0), material);
    this.mesh.add(this.head);
    this.mesh.renderOrder = this.head.renderOrder = 4;
    this.mesh.visible = false;
  }

  // newton, scene frame; undefined: none is felt.
  set(forceN: readonly [number, number, number] | undefined): void {
    this.force = forceN;
  }

  // `tip`: where it begins; undefined: no tool is drawn.
  place(tip: Vector3 | undefined): void {
    this.mesh.visible = tip !== undefined && this.force !== undefined;
    if (tip === undefined || this.force === undefined) return;
    const lengthMm = Math.min(kMostMm, Math.hypot(...this.force) * kArrowMmPerN);
    this.mesh.position.copy(tip);
    this.mesh.quaternion.setFromUnitVectors(kUp, new Vector3(...this.force).normalize());
    this.mesh.scale.set(1, lengthMm, 1);
    this.head.position.set(0, 1, 0);
    this.head.scale.set(1, 1 / lengthMm, 1); // the head keeps its size
  }

  dispose(): void {
    this.mesh.geometry.dispose();
    this.head.geometry.dispose();
    (this.mesh.material as MeshBasicMaterial).dispose();
  }
}
