import { PerspectiveCamera, Quaternion, Spherical, Vector3 } from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";
import { type Anatomy, toScene } from "../../api/tooth_number";
import type { Extent } from "../../api/tooth_work";
import type { Look } from "../../base/moment_link";
import type { PointMm } from "./lines";

// From where a tooth is looked at. The crown is always up in the picture, whichever side is up at the station.

export type CameraPreset = "angled" | "cavity" | "occlusal" | "buccal" | "lingual" | "mesial" | "distal" | "apical";

// The view into the cavity: direction and target.
export interface AngledView {
  readonly direction: PointMm;
  readonly centre: PointMm | undefined; // undefined: the middle of the tooth
  readonly cavity?: Extent | undefined; // what "cavity" frames; undefined: as "angled"
}

// From the target towards the camera: mesial, buccal, occlusal. The caller gives "angled".
const kDirections: Readonly<Record<Exclude<CameraPreset, "angled" | "cavity">, PointMm>> = {
  occlusal: [0, -0.001, 1],
  buccal: [0, 1, 0.25],
  lingual: [0, -1, 0.25],
  mesial: [1, 0, 0.25],
  distal: [-1, 0, 0.25],
  apical: [0, 0.001, -1],
};
const kFieldOfViewDeg = 28;
const kMargin = 1.02; // of the bounding sphere, so that nothing touches the edge
const kIntoCavity: PointMm = [0.12, -0.3, 1]; // scene frame: the side that is worked on is up at the station
const kCavityMargin = 1.25; // a little of what is around it
const kAngledCloser = 0.8; // of the distance at which the whole tooth is in view
const kLeastRadiusMm = 0.5;
const kNearShare = 0.65; // of the cavity, around a place in it
const kNearLeastMm = 1;
const kNearTilt = 0.7; // away from straight above, to face the wall that the place is on
const kMinPolar = 0.001; // Spherical turns over at the poles
const kSceneUp = new Vector3(0, 0, 1);

export class Sight {
  readonly camera = new PerspectiveCamera(kFieldOfViewDeg, 1, 0.1, 500);
  private controls: OrbitControls;
  private canvas: HTMLCanvasElement | undefined;
  private anatomy: Anatomy = { mesial: 1, up: "occlusal" };
  private turning = false; // by the pointer
  private untouched = true; // as it began: nobody has turned it

  // `changed`: another picture is wanted; `turning`: more will follow at once.
  constructor(
    private readonly centre: Vector3,
    private readonly radius: number,
    private angled: AngledView,
    private readonly changed: (turning: boolean) => void,
  ) {
    this.camera.up.copy(kSceneUp);
    this.controls = this.orbit();
    this.begin();
  }

  private orbit(): OrbitControls {
    const controls = new OrbitControls(this.camera);
    controls.enablePan = false;
    controls.enableZoom = false;
    controls.minDistance = this.radius * 0.2;
    controls.maxDistance = this.radius * 12;
    controls.addEventListener("change", () => this.changed(this.turning));
    controls.addEventListener("start", () => {
      this.untouched = false;
      this.turning = true;
    });
    controls.addEventListener("end", () => {
      this.turning = false;
    });
    return controls;
  }

  // The pointer turns it from now on.
  attach(canvas: HTMLCanvasElement): void {
    this.canvas = canvas;
    this.controls.connect(canvas);
    // A finger may still scroll the page over the picture; sideways it turns the tooth.
    canvas.style.touchAction = "pan-y";
  }
  dispose(): void {
    if (this.canvas !== undefined) this.controls.dispose();
  }

  get target(): Vector3 {
    return this.controls.target;
  }
  // From the target to the camera.
  get away(): Vector3 {
    return this.camera.position.clone().sub(this.controls.target);
  }

  // Wheel and pinch zoom take over the page's own scrolling, so only while the view has the focus.
  setZoomEnabled(enabled: boolean): void {
    this.controls.enableZoom = enabled;
  }

  // A tooth that somebody has turned keeps its view.
  setAngled(angled: AngledView): void {
    this.angled = angled;
    this.begin();
  }
  setAnatomy(anatomy: Anatomy): void {
    this.anatomy = anatomy;
    this.camera.up.set(...toScene(anatomy, [0, 0, 1]));
    // OrbitControls reads what is up when it is made, and never again.
    const { target, enableZoom } = this.controls;
    this.dispose();
    this.controls = this.orbit();
    this.controls.target.copy(target);
    this.controls.enableZoom = enableZoom;
    if (this.canvas !== undefined) this.attach(this.canvas);
    if (this.untouched) this.begin();
    else this.controls.update();
  }
  private begin(): void {
    if (!this.untouched) return;
    this.view("cavity");
    this.untouched = true;
  }

  resize(width: number, height: number): void {
    const before = this.fitDistance();
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    const { untouched } = this;
    this.zoom(this.fitDistance() / before);
    this.untouched = untouched;
  }

  view(preset: CameraPreset): void {
    const { direction, centre, cavity } = this.angled;
    if (preset === "cavity" && cavity !== undefined) {
      const radius = Math.max(cavity.radiusMm * kCavityMargin, kLeastRadiusMm);
      this.lookAt(new Vector3(...cavity.centreMm), kIntoCavity, this.fitDistance(radius));
    } else if (preset === "angled" || preset === "cavity")
      this.lookAt(
        centre === undefined ? this.centre : new Vector3(...centre),
        direction,
        this.fitDistance() * kAngledCloser,
      );
    else this.lookAt(this.centre, toScene(this.anatomy, kDirections[preset]), this.fitDistance());
  }

  // A place in the cavity, so near that it fills the picture, facing the wall that it is on.
  near(point: PointMm): void {
    const { cavity } = this.angled;
    const inwards = new Vector3(...(cavity?.centreMm ?? point)).sub(new Vector3(...point)).setZ(0);
    if (inwards.lengthSq() > 0) inwards.setLength(kNearTilt);
    const radius = Math.max((cavity?.radiusMm ?? this.radius) * kNearShare, kNearLeastMm);
    this.lookAt(new Vector3(...point), inwards.setZ(1).toArray(), this.fitDistance(radius));
  }

  private lookAt(target: Vector3, direction: PointMm, distance: number): void {
    this.untouched = false;
    this.controls.target.copy(target);
    this.camera.position.copy(target).addScaledVector(new Vector3(...direction).normalize(), distance);
    this.controls.update();
  }

  follow(point: Vector3): void {
    const moved = point.clone().sub(this.controls.target);
    this.controls.target.add(moved);
    this.camera.position.add(moved);
    this.controls.update();
    this.untouched = false;
  }

  look(): Look {
    const { theta, phi, radius } = this.spherical();
    return {
      azimuthRad: theta,
      polarRad: phi,
      fitsMm: radius / this.fitDistance(1),
      centreMm: this.controls.target.toArray(),
    };
  }
  setLook({ azimuthRad, polarRad, fitsMm, centreMm }: Look): void {
    this.controls.target.set(...centreMm);
    this.move((offset) => offset.set(this.fitDistance(fitsMm), bounded(polarRad), azimuthRad));
  }

  rotate(azimuthRad: number, polarRad: number): void {
    this.move((offset) => {
      offset.theta += azimuthRad;
      offset.phi = bounded(offset.phi + polarRad);
    });
  }
  zoom(factor: number): void {
    this.move((offset) => {
      offset.radius *= factor;
    });
  }

  // Around what is up: 0 from straight above.
  private spherical(): Spherical {
    return new Spherical().setFromVector3(this.away.applyQuaternion(this.upright()));
  }
  // Spherical has y up.
  private upright(): Quaternion {
    return new Quaternion().setFromUnitVectors(this.camera.up, new Vector3(0, 1, 0));
  }

  private move(change: (offset: Spherical) => void): void {
    this.untouched = false;
    const offset = this.spherical();
    change(offset);
    const away = new Vector3().setFromSpherical(offset).applyQuaternion(this.upright().invert());
    this.camera.position.copy(this.controls.target).add(away);
    this.controls.update();
  }

  // At which a ball of that radius just fits into the picture.
  private fitDistance(radius = this.radius): number {
    const half = (kFieldOfViewDeg * Math.PI) / 360;
    const narrow = Math.min(1, this.camera.aspect);
    return (radius * kMargin) / Math.sin(Math.atan(Math.tan(half) * narrow));
  }
}

function bounded(polarRad: number): number {
  return Math.min(Math.max(polarRad, kMinPolar), Math.PI - kMinPolar);
}
