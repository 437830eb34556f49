import { type Anatomy, fromScene, toScene } from "../../api/tooth_number";
import type { Look } from "../../base/moment_link";
import type { AngledView, CameraPreset, Extent, PointMm } from "../messages";
import {
  add,
  dot,
  inverse,
  lengthOf,
  type Matrix,
  perspective,
  product,
  type Quat,
  scaled,
  sub,
  turnBetween,
  turned,
  type Vec,
  viewFrom,
  withLength,
} from "./vec";

// From where a tooth is looked at. The crown is always up in the picture, whichever side is up at the station.

const kAside = 0.001; // from straight above or below, so that something is up in the picture
const kStraight = 0.999; // cosine: more is straight above or below

// From the target towards the camera: mesial, buccal, occlusal. The caller gives "angled".
const kDirections: Readonly<Record<Exclude<CameraPreset, "angled" | "cavity">, PointMm>> = {
  occlusal: [0, -kAside, 1],
  buccal: [0, 1, 0.25],
  lingual: [0, -1, 0.25],
  mesial: [1, 0, 0.25],
  distal: [-1, 0, 0.25],
  apical: [0, kAside, -1],
};
const kFieldOfViewDeg = 28;
const kMargin = 1.02; // of the bounding sphere, so that nothing touches the edge
const kIntoCavity: PointMm = [0.12, -0.3, 1]; // scene frame: the side that is worked on is up at the station
const kCavityMargin = 1.25; // a little of what is around it
const kAngledCloser = 0.8; // of the distance at which the whole tooth is in view
const kMinRadiusMm = 0.5;
const kNearShare = 0.65; // of the cavity, around a place in it
const kNearLeastMm = 1;
const kNearTilt = 0.7; // away from straight above, to face the wall that the place is on
const kMinPolar = 0.001; // straight from above or below nothing is up
const [kNearest, kFarthest] = [0.2, 12]; // of the tooth's radius
const kSceneUp: Vec = [0, 0, 1];
const [kNearMm, kFarMm] = [0.1, 500]; // what a camera sees
const kHalfHigh = Math.tan((kFieldOfViewDeg * Math.PI) / 360);

// Around what is up: radius, angle from straight above, and around.
interface Round {
  readonly radius: number;
  readonly polar: number;
  readonly around: number;
}

export class Sight {
  eye: Vec = [0, 0, 0]; // where the camera is
  target: Vec = [0, 0, 0];
  up: Vec = kSceneUp;
  aspect = 1; // of the picture: width / height
  private centre: Vec = [0, 0, 0];
  private radius = 1;
  private placed = false; // it is known where the tooth is
  private anatomy: Anatomy = { mesial: 1, up: "occlusal" };
  private untouched = true; // as it began: nobody has turned it

  // `changed`: another picture is wanted.
  constructor(
    private angled: AngledView,
    private readonly changed: () => void,
  ) {
    this.begin();
  }

  // From the target to the camera.
  get away(): Vec {
    return sub(this.eye, this.target);
  }
  // Of the picture, at what is looked at.
  get halfHighMm(): number {
    return lengthOf(this.away) * kHalfHigh;
  }
  // From the scene to the camera, and on to −1 … 1.
  get fromScene(): Matrix {
    return viewFrom(this.eye, this.target, this.up);
  }
  get projection(): Matrix {
    return perspective(kHalfHigh, this.aspect, kNearMm, kFarMm);
  }
  get picture(): Matrix {
    return product(this.projection, this.fromScene);
  }

  // Where a section begins, the middle of the cavity, and how far it can be moved: past either end of the tooth.
  get cutOpen(): Extent {
    const centreMm = this.angled.cavity?.centreMm ?? this.centre;
    const aside = sub(centreMm, this.centre);
    return { centreMm, radiusMm: this.radius + Math.sqrt(dot(aside, aside)) };
  }

  // The way from the camera through a place of the picture, −1 … 1 to the right and up.
  wayThrough(right: number, up: number): Vec {
    const [x, y, back] = this.axes();
    return sub(add(scaled(x, right * kHalfHigh * this.aspect), scaled(y, up * kHalfHigh)), back);
  }
  // Right, up and backwards in the picture.
  private axes(): readonly [Vec, Vec, Vec] {
    const m = this.fromScene;
    const row = (i: number): Vec => [m[i]!, m[i + 4]!, m[i + 8]!];
    return [row(0), row(1), row(2)];
  }

  // A tooth that somebody has turned keeps its view.
  setExtent({ centreMm, radiusMm }: Extent): void {
    this.centre = centreMm;
    this.radius = radiusMm;
    this.placed = true;
    if (this.untouched) this.begin();
    else this.place();
  }
  setAngled(angled: AngledView): void {
    this.angled = angled;
    this.begin();
  }
  // A tooth that is turned turns in the picture.
  setAnatomy(anatomy: Anatomy): void {
    if (anatomy.turn !== undefined)
      this.eye = add(this.target, toScene(anatomy, fromScene({ ...anatomy, turn: this.anatomy.turn }, this.away)));
    this.anatomy = anatomy;
    this.up = toScene(anatomy, [0, 0, 1]);
    if (this.untouched) this.begin();
    else this.place();
  }
  private begin(): void {
    if (!this.untouched) return;
    this.view("cavity");
    this.untouched = true;
  }

  reset(): void {
    this.untouched = true;
    this.begin();
  }

  resize(width: number, height: number): void {
    const before = this.fitDistance();
    this.aspect = width / height;
    const { untouched } = this;
    this.zoom(this.fitDistance() / before);
    this.untouched = untouched;
  }

  view(preset: CameraPreset): void {
    const { direction, centre, cavity, closer = kAngledCloser } = this.angled;
    if (preset === "cavity" && cavity !== undefined) {
      const radius = Math.max(cavity.radiusMm * kCavityMargin, kMinRadiusMm);
      this.lookAt(cavity.centreMm, kIntoCavity, this.fitDistance(radius));
    } else if (preset === "angled" || preset === "cavity")
      this.lookAt(centre ?? this.centre, direction, this.fitDistance() * closer);
    else this.lookAt(this.centre, toScene(this.anatomy, kDirections[preset]), this.fitDistance());
  }

  // Straight at a plane; its normal points away from the viewer.
  face(normal: Vec): void {
    // From straight above or below buccal is up, as in the views from there.
    const above = dot(normal, this.up);
    const tilt =
      Math.abs(above) > kStraight ? toScene(this.anatomy, [0, Math.sign(above) * kAside, 0]) : ([0, 0, 0] as const);
    this.lookAt(this.target, sub(tilt, normal), lengthOf(this.away));
  }

  // A place in the cavity, so near that it fills the picture, facing the wall that it is on.
  near(point: PointMm): void {
    const { cavity } = this.angled;
    const [x, y] = sub(cavity?.centreMm ?? point, point);
    const [inX, inY] = withLength([x, y, 0], kNearTilt);
    const radius = Math.max((cavity?.radiusMm ?? this.radius) * kNearShare, kNearLeastMm);
    this.lookAt(point, [inX, inY, 1], this.fitDistance(radius));
  }

  private lookAt(target: Vec, direction: PointMm, distance: number): void {
    this.untouched = false;
    this.target = target;
    this.eye = add(target, withLength(direction, distance));
    this.place();
  }
  private place(): void {
    if (this.placed) {
      const far = Math.min(Math.max(lengthOf(this.away), kNearest * this.radius), kFarthest * this.radius);
      this.eye = add(this.target, withLength(this.away, far));
    }
    this.changed();
  }

  follow(point: Vec): void {
    this.eye = add(this.eye, sub(point, this.target));
    this.target = point;
    this.place();
    this.untouched = false;
  }

  look(): Look {
    const { around, polar, radius } = this.round();
    return { azimuthRad: around, polarRad: polar, fitsMm: radius / this.fitDistance(1), centreMm: this.target };
  }
  setLook({ azimuthRad, polarRad, fitsMm, centreMm }: Look): void {
    this.target = centreMm;
    this.move({ radius: this.fitDistance(fitsMm), polar: polarRad, around: azimuthRad });
  }

  rotate(azimuthRad: number, polarRad: number): void {
    const { radius, polar, around } = this.round();
    this.move({ radius, polar: polar + polarRad, around: around + azimuthRad });
  }
  zoom(factor: number): void {
    const { radius, ...rest } = this.round();
    this.move({ ...rest, radius: radius * factor });
  }

  // Looks at what lies aside, `right` and `up` of half the picture's height from the middle.
  pan(right: number, up: number): void {
    const [x, y] = this.axes();
    const size = this.halfHighMm;
    this.untouched = false;
    const aside = add(scaled(x, right * size), scaled(y, up * size));
    this.eye = add(this.eye, aside);
    this.target = add(this.target, aside);
    this.place();
  }

  private round(): Round {
    const [x, y, z] = turned(this.upright(), this.away);
    const radius = Math.hypot(x, y, z);
    return { radius, polar: Math.acos(Math.min(Math.max(y / radius, -1), 1)), around: Math.atan2(x, z) };
  }
  // Turns what is up to +y.
  private upright(): Quat {
    return turnBetween(this.up, [0, 1, 0]);
  }
  private move({ radius, polar, around }: Round): void {
    this.untouched = false;
    const from = Math.min(Math.max(polar, kMinPolar), Math.PI - kMinPolar);
    const way: Vec = [Math.sin(from) * Math.sin(around), Math.cos(from), Math.sin(from) * Math.cos(around)];
    this.eye = add(this.target, scaled(turned(inverse(this.upright()), way), radius));
    this.place();
  }

  // At which a ball of that radius just fits into the picture.
  private fitDistance(radius = this.radius): number {
    return (radius * kMargin) / Math.sin(Math.atan(kHalfHigh * Math.min(1, this.aspect)));
  }
}
