import {
  AmbientLight,
  BufferGeometry,
  Line,
  LineBasicMaterial,
  Mesh,
  type MeshStandardMaterial,
  PerspectiveCamera,
  Raycaster,
  Scene,
  Spherical,
  type ShaderMaterial,
  Vector2,
  Vector3,
  WebGLRenderer,
} from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";
import type { Surface } from "../../api/surface";
import type { MesialX } from "../../api/tooth_number";
import type { BlockMesh } from "../../api/tooth_mesh";
import type { Extent } from "../../api/tooth_work";
import { Disposables } from "../../base/disposables";
import { FrameScheduler } from "../../base/frame";
import type { Look } from "../../base/moment_link";
import { kUntouchedColor } from "./deviation_scale";
import { type BlockHit, ToothBlocks } from "./blocks";
import type { Film, FilmPose, FilmScreen } from "./film";
import { ForceArrow } from "./force_arrow";
import { LineGroup } from "./line_group";
import type { PointMm, ToothLines } from "./lines";
import { Ghost, markBy } from "./ghost";
import { cutBy, quickMaterial } from "./quick_material";
import { DrawingPace, drawsSlowly, type Effort, setDrawing } from "./renderer";
import { addLights, burMesh, kInsideColor, toolMarker, toothGeometry, toothMaterial, wholeOf } from "./scene_meshes";
import { type Cuttable, Section, type SectionPlane } from "./section";
import { TriangleGrid } from "./triangle_grid";

export type ColorMode = "tissue" | "deviation";
export type CameraPreset = "angled" | "cavity" | "occlusal" | "buccal" | "lingual" | "mesial" | "distal" | "apical";
export type { PointMm };

// The view into the cavity: direction and target.
export interface AngledView {
  readonly direction: PointMm;
  readonly centre: PointMm | undefined; // undefined: the middle of the tooth
  readonly cavity?: Extent | undefined; // what "cavity" frames; undefined: as "angled"
}

export interface SurfacePoint {
  readonly tissue: number;
  readonly deviationMm: number | undefined; // NaN: untouched; undefined: nothing to compare with
  readonly pointMm: PointMm; // where exactly
}

// From the target towards the camera; scene frame with mesial at +x. The caller gives "angled".
const kDirections: Readonly<Record<Exclude<CameraPreset, "angled" | "cavity">, PointMm>> = {
  occlusal: [0, -0.001, 1],
  buccal: [0, 1, 0.25],
  lingual: [0, -1, 0.25],
  mesial: [1, 0, 0.25],
  distal: [-1, 0, 0.25],
  apical: [0, -0.001, -1],
};
const kFieldOfViewDeg = 28;
const kMargin = 1.02; // of the bounding sphere, so that nothing touches the edge
const kIntoCavity: PointMm = [0.12, -0.3, 1];
const kCavityMargin = 1.25; // a little of what is around it
const kAngledCloser = 0.8; // of the distance at which the whole tooth is in view
const kSamePlaceMm = 1e-3;
const kLeastRadiusMm = 0.5;
const kMinPolar = 0.001; // Spherical turns over at the poles

// The drawn tooth: a fixed surface, or blocks that come and change.
export type ToothModel = { readonly surface: Surface } | { readonly extent: Extent };

// The three.js side of the tooth view: owns the WebGL context, draws only when something changed.
// Throws from the constructor where WebGL 2 is not available.
export class ToothScene implements FilmScreen {
  private readonly renderer: WebGLRenderer;
  private readonly scene = new Scene();
  private readonly camera = new PerspectiveCamera(kFieldOfViewDeg, 1, 0.1, 500);
  private readonly controls: OrbitControls;
  private readonly cleanup = new Disposables();
  private readonly frame = new FrameScheduler(() => this.draw());
  private readonly heat = { value: 0 };
  private readonly surface: Surface | undefined;
  private readonly blocks: ToothBlocks;
  private grid: TriangleGrid | undefined; // made when something is first looked up
  private readonly marker: Mesh;
  private bur: Mesh | undefined;
  private readonly trail: Line;
  private readonly arrow = new ForceArrow();
  private readonly lines = new LineGroup();
  private readonly centre = new Vector3();
  private readonly radius: number;
  private readonly material: MeshStandardMaterial;
  private readonly quick: ShaderMaterial;
  private readonly whole: Mesh | undefined; // the surface that stays as it is
  private readonly pace: DrawingPace;
  private readonly section = new Section();
  private readonly parts: () => Iterable<Cuttable>;
  private ghost: { readonly drawn: Ghost; readonly end: () => void } | undefined;
  private follows = false; // the camera stays at the bur
  private turning = false; // by the pointer
  private untouched = true; // as it began: nobody has turned it

  constructor(
    private readonly canvas: HTMLCanvasElement,
    model: ToothModel,
    private angled: AngledView,
    private readonly drawn: (project: (point: PointMm) => PointMm, centre: PointMm, radius: number) => void,
  ) {
    const slow = drawsSlowly();
    this.renderer = new WebGLRenderer({
      canvas,
      antialias: !slow,
      alpha: true,
      stencil: true,
      powerPreference: "low-power",
    });
    // Asking for a shader's errors waits until the driver has made it.
    this.renderer.debug.checkShaderErrors = false;
    this.cleanup.add(() => this.renderer.dispose());
    this.material = toothMaterial(this.heat, this.cleanup);
    const { material } = this;
    this.quick = quickMaterial({ heat: this.heat, untouched: kUntouchedColor, inside: kInsideColor });
    this.cleanup.add(() => this.quick.dispose());
    this.pace = new DrawingPace(
      slow,
      (effort) => this.setEffort(effort),
      () => this.draw(),
    );
    this.cleanup.add(() => this.pace.stop());
    this.blocks = new ToothBlocks(material);
    this.cleanup.add(() => this.blocks.dispose());
    this.marker = toolMarker();
    this.trail = new Line(
      new BufferGeometry(),
      new LineBasicMaterial({ color: 0x101418, depthTest: false, transparent: true, opacity: 0.55 }),
    );
    this.trail.renderOrder = 1;
    this.trail.frustumCulled = false;
    this.cleanup.add(() => this.arrow.dispose());
    this.cleanup.add(() => this.lines.dispose());
    this.scene.add(
      this.blocks.group,
      this.section.outline,
      this.trail,
      this.marker,
      this.arrow.mesh,
      this.lines.group,
      this.camera,
      new AmbientLight(0xffffff, 1.3),
    );
    addLights(this.camera);
    this.whole = "surface" in model ? new Mesh(toothGeometry(model.surface), material) : undefined;
    this.radius = this.take(model, this.whole);
    this.parts = "extent" in model ? () => this.blocks.meshes() : wholeOf(model.surface);
    this.cleanup.add(() => this.section.dispose());
    this.cleanup.add(() => this.endGhost());
    this.surface = "surface" in model ? model.surface : undefined;
    this.controls = this.orbit();
    this.cleanup.add(() => this.frame.cancel());
    this.cleanup.listen(window, "beforeprint", () => {
      this.pace.settle();
      this.draw();
    }); // paper gets what was drawn last
    this.view("angled");
    this.untouched = true;
  }

  // Returns the radius of the drawn tooth, and sets its centre.
  private take(model: ToothModel, whole: Mesh | undefined): number {
    if ("extent" in model) {
      this.centre.set(...model.extent.centreMm);
      return Math.max(model.extent.radiusMm, kLeastRadiusMm);
    }
    if (whole !== undefined) {
      this.scene.add(whole);
      this.cleanup.add(() => whole.geometry.dispose());
    }
    const sphere = whole?.geometry.boundingSphere ?? null;
    if (sphere !== null) this.centre.copy(sphere.center);
    return Math.max(sphere?.radius ?? 1, kLeastRadiusMm);
  }

  dispose(): void {
    this.cleanup.dispose();
  }

  // Where "angled" looks from and at. A tooth that somebody has turned keeps its view.
  setAngled(angled: AngledView): void {
    this.angled = angled;
    if (!this.untouched) return;
    this.view("angled");
    this.untouched = true;
  }

  setMode(mode: ColorMode): void {
    this.heat.value = mode === "deviation" ? 1 : 0;
    this.frame.request();
  }

  // Wheel and pinch zoom take over the page's own scrolling, so only while the view has the focus.
  setZoomEnabled(enabled: boolean): void {
    this.controls.enableZoom = enabled;
  }

  setTool(point: PointMm | undefined, path: readonly PointMm[]): void {
    this.marker.visible = point !== undefined;
    if (point !== undefined) this.marker.position.set(...point);
    this.trail.geometry.dispose();
    this.trail.geometry = new BufferGeometry().setFromPoints(path.map((p) => new Vector3(...p)));
    this.trail.visible = path.length > 1;
    this.placeArrow();
    this.frame.request();
  }

  // Undefined: none.
  setLines(lines: ToothLines | undefined): void {
    this.lines.set(lines);
    this.frame.request();
  }

  // The force on the hand, N; undefined: none is felt. Drawn at the bur or, where none is shown, at
  // the tool's mark.
  setForce(forceN: PointMm | undefined): void {
    this.arrow.set(forceN);
    this.placeArrow();
    this.frame.request();
  }
  private placeArrow(): void {
    this.arrow.place(
      this.bur?.visible === true ? this.bur.position : this.marker.visible ? this.marker.position : undefined,
    );
  }

  expect(): void {
    this.pace.moved();
  }
  setBlock(index: number, mesh: BlockMesh | undefined): void {
    this.blocks.set(index, mesh);
    this.section.changed();
    this.moved();
  }
  setBur(outline: readonly (readonly [number, number])[], pose: FilmPose | undefined): void {
    if (this.bur === undefined && pose !== undefined && outline.length > 1) {
      this.bur = burMesh(outline);
      this.scene.add(this.bur);
      this.cleanup.add(() => this.bur?.geometry.dispose());
    }
    if (this.bur === undefined) return;
    this.bur.visible = pose !== undefined;
    if (pose !== undefined) {
      this.bur.position.set(...pose.tipMm);
      this.bur.quaternion.setFromUnitVectors(new Vector3(0, 0, 1), new Vector3(...pose.axis).normalize());
      if (this.follows) this.follow();
    }
    this.placeArrow();
    this.moved();
  }

  // Another tooth over this one, translucent; undefined: none. It can neither be pointed at nor
  // does it change what is framed.
  setGhost(film: Film | undefined): void {
    this.endGhost();
    if (film !== undefined) {
      const drawn = new Ghost(
        () => this.pace.moved(),
        () => this.moved(),
      );
      this.scene.add(drawn.group);
      this.ghost = { drawn, end: film.attach(drawn) };
      this.cutGhost();
    }
    for (const material of [this.material, this.quick]) markBy(material, film !== undefined);
    this.frame.request();
  }
  private endGhost(): void {
    if (this.ghost === undefined) return;
    const { drawn, end } = this.ghost;
    this.ghost = undefined;
    end();
    this.scene.remove(drawn.group);
    drawn.dispose();
  }
  private cutGhost(): void {
    this.ghost?.drawn.section.set(this.section.wanted);
    this.ghost?.drawn.cutBy(this.section.on ? this.section.plane : undefined);
  }

  // Undefined: none. The hidden part cannot be pointed at either.
  setSection(plane: SectionPlane | undefined): void {
    const was = this.section.on;
    this.section.set(plane);
    if (was !== this.section.on) {
      this.renderer.localClippingEnabled = this.section.on;
      for (const material of [this.material, this.quick])
        cutBy(material, this.section.on ? this.section.plane : undefined);
    }
    this.cutGhost();
    this.frame.request();
  }
  setFollow(on: boolean): void {
    this.follows = on;
    if (on) this.follow();
  }
  private follow(): void {
    if (this.bur?.visible !== true) return;
    const moved = this.bur.position.clone().sub(this.controls.target);
    this.controls.target.add(moved);
    this.camera.position.add(moved);
    this.controls.update();
    this.untouched = false;
  }

  // What lies over the picture has moved without it.
  redraw(): void {
    this.frame.request();
  }

  // More motion is likely to follow at once.
  private moved(): void {
    this.pace.moved();
    this.frame.request();
  }

  resize(width: number, height: number): void {
    if (width < 1 || height < 1) return;
    const previous = this.fitDistance();
    setDrawing(this.renderer, this.pace.effort);
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    const { untouched } = this;
    this.zoom(this.fitDistance() / previous);
    this.untouched = untouched;
  }

  view(preset: CameraPreset, mesial: MesialX = 1): void {
    this.untouched = false;
    const { direction, centre, cavity } = this.angled;
    if (preset === "cavity" && cavity !== undefined) {
      return this.lookAt(
        new Vector3(...cavity.centreMm),
        new Vector3(...kIntoCavity),
        this.fitDistance(Math.max(cavity.radiusMm * kCavityMargin, kLeastRadiusMm)),
      );
    }
    if (preset === "angled" || preset === "cavity")
      return this.lookAt(
        centre === undefined ? this.centre : new Vector3(...centre),
        new Vector3(...direction),
        this.fitDistance() * kAngledCloser,
      );
    const [x, y, z] = kDirections[preset];
    this.lookAt(this.centre, new Vector3(x * mesial, y, z), this.fitDistance());
  }

  private lookAt(target: Vector3, direction: Vector3, distance: number): void {
    this.controls.target.copy(target);
    this.camera.position.copy(target).addScaledVector(direction.normalize(), distance);
    this.controls.update();
    this.frame.request();
  }

  look(): Look {
    const away = this.camera.position.clone().sub(this.controls.target);
    const { theta, phi, radius } = new Spherical().setFromCartesianCoords(away.x, away.z, -away.y);
    return {
      azimuthRad: theta,
      polarRad: phi,
      distance: radius / this.fitDistance(),
      atCut: this.controls.target.distanceTo(this.centre) > kSamePlaceMm,
    };
  }
  setLook({ azimuthRad, polarRad, distance, atCut }: Look): void {
    this.view(atCut ? "angled" : "occlusal"); // for what is looked at
    this.moveCamera((offset) => {
      offset.set(
        distance * this.fitDistance(),
        Math.min(Math.max(polarRad, kMinPolar), Math.PI - kMinPolar),
        azimuthRad,
      );
    });
  }

  rotate(azimuthRad: number, polarRad: number): void {
    this.moveCamera((offset) => {
      offset.theta += azimuthRad;
      offset.phi = Math.min(Math.max(offset.phi + polarRad, kMinPolar), Math.PI - kMinPolar);
    });
  }

  zoom(factor: number): void {
    this.moveCamera((offset) => {
      offset.radius *= factor;
    });
  }

  // What is under a point of the canvas, in CSS pixels from its top left corner.
  pick(x: number, y: number): SurfacePoint | undefined {
    const pointer = new Vector2((2 * x) / this.canvas.clientWidth - 1, 1 - (2 * y) / this.canvas.clientHeight);
    const ray = new Raycaster();
    ray.setFromCamera(pointer, this.camera);
    if (this.surface === undefined)
      return pointOf(this.blocks.firstHit(ray.ray.origin, ray.ray.direction, (at) => this.isShown(at)));
    this.grid ??= new TriangleGrid(this.surface.positionMm, this.surface.triangle);
    const hit = this.grid.firstHit(ray.ray.origin.toArray(), ray.ray.direction.toArray(), (at) => this.isShown(at));
    const vertex = hit === undefined ? undefined : this.surface.triangle[3 * hit.triangle];
    if (hit === undefined || vertex === undefined) return undefined;
    return {
      tissue: this.surface.tissue[vertex] ?? 0,
      deviationMm: this.surface.deviationMm?.[vertex],
      pointMm: hit.at,
    };
  }

  private isShown(at: PointMm): boolean {
    return !this.section.on || this.section.plane.distanceToPoint(new Vector3(...at)) >= 0;
  }

  private setEffort(effort: Effort): void {
    const material = effort === "quick" ? this.quick : this.material;
    this.blocks.use(material);
    if (this.whole !== undefined) this.whole.material = material;
    setDrawing(this.renderer, effort);
  }

  private draw(): void {
    this.canvas.dataset["drawn"] = this.pace.effort;
    const sight = this.camera.position.clone().sub(this.controls.target);
    this.section.update(this.centre, this.radius, sight, this.parts);
    this.ghost?.drawn.section.update(this.centre, this.radius, sight, this.ghost.drawn.parts);
    this.renderer.render(this.scene, this.camera);
    this.drawn((point) => this.project(point), this.centre.toArray(), this.radius);
  }

  // CSS pixels from the canvas's top left corner, and depth.
  private project(point: PointMm): PointMm {
    const at = new Vector3(...point).project(this.camera);
    return [((at.x + 1) / 2) * this.canvas.clientWidth, ((1 - at.y) / 2) * this.canvas.clientHeight, at.z];
  }

  private fitDistance(radius = this.radius): number {
    const half = (kFieldOfViewDeg * Math.PI) / 360;
    const narrow = Math.min(1, this.camera.aspect);
    return (radius * kMargin) / Math.sin(Math.atan(Math.tan(half) * narrow));
  }

  private moveCamera(change: (offset: Spherical) => void): void {
    this.untouched = false;
    // Spherical has y up, the scene z.
    const away = this.camera.position.clone().sub(this.controls.target);
    const offset = new Spherical().setFromCartesianCoords(away.x, away.z, -away.y);
    change(offset);
    const moved = new Vector3().setFromSpherical(offset);
    this.camera.position.copy(this.controls.target).add(new Vector3(moved.x, -moved.z, moved.y));
    this.controls.update();
    this.frame.request();
  }

  private orbit(): OrbitControls {
    const controls = new OrbitControls(this.camera, this.canvas);
    controls.enablePan = false;
    controls.enableZoom = false;
    controls.minDistance = this.radius * 0.2;
    controls.maxDistance = this.radius * 12;
    // A finger may still scroll the page over the picture; sideways it turns the tooth.
    this.canvas.style.touchAction = "pan-y";
    controls.addEventListener("change", () => (this.turning ? this.moved() : this.frame.request()));
    controls.addEventListener("start", () => {
      this.untouched = false;
      this.turning = true;
    });
    controls.addEventListener("end", () => {
      this.turning = false;
    });
    this.cleanup.add(() => controls.dispose());
    return controls;
  }
}

// A place whose deviation is not known looks untouched.
function pointOf(hit: BlockHit | undefined): SurfacePoint | undefined {
  if (hit === undefined) return undefined;
  const {
    mesh: { tissue, deviation },
    vertex,
    at,
  } = hit;
  const deviationMm =
    deviation === undefined ? undefined : deviation[2 * vertex + 1] === 0 ? Number.NaN : deviation[2 * vertex];
  return { tissue: tissue[vertex] ?? 0, deviationMm, pointMm: at };
}
