import {
  AmbientLight,
  BufferGeometry,
  Line,
  LineBasicMaterial,
  Mesh,
  type MeshStandardMaterial,
  Raycaster,
  Scene,
  type ShaderMaterial,
  Vector2,
  Vector3,
  WebGLRenderer,
} from "three";
import type { Surface } from "../../api/surface";
import type { Anatomy } from "../../api/tooth_number";
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
import { type AngledView, type CameraPreset, Sight } from "./sight";
import { TriangleGrid } from "./triangle_grid";

export type ColorMode = "tissue" | "deviation";
export type { AngledView, CameraPreset };
export type { PointMm };

export interface SurfacePoint {
  readonly tissue: number;
  readonly deviationMm: number | undefined; // NaN: untouched; undefined: nothing to compare with
  readonly pointMm: PointMm; // where exactly
}

const kLeastRadiusMm = 0.5;

// The drawn tooth: a fixed surface, or blocks that come and change.
export type ToothModel = { readonly surface: Surface } | { readonly extent: Extent };

// The three.js side of the tooth view: owns the WebGL context, draws only when something changed.
// Throws from the constructor where WebGL 2 is not available.
export class ToothScene implements FilmScreen {
  private readonly renderer: WebGLRenderer;
  private readonly scene = new Scene();
  private readonly sight: Sight;
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

  constructor(
    private readonly canvas: HTMLCanvasElement,
    model: ToothModel,
    angled: AngledView,
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
      new AmbientLight(0xffffff, 1.3),
    );
    this.whole = "surface" in model ? new Mesh(toothGeometry(model.surface), material) : undefined;
    this.radius = this.take(model, this.whole);
    this.parts = "extent" in model ? () => this.blocks.meshes() : wholeOf(model.surface);
    this.cleanup.add(() => this.section.dispose());
    this.cleanup.add(() => this.endGhost());
    this.surface = "surface" in model ? model.surface : undefined;
    this.sight = new Sight(this.centre, this.radius, angled, (turning) =>
      turning ? this.moved() : this.frame.request(),
    );
    this.sight.attach(canvas);
    this.cleanup.add(() => this.sight.dispose());
    this.scene.add(this.sight.camera);
    addLights(this.sight.camera);
    this.cleanup.add(() => this.frame.cancel());
    this.cleanup.listen(window, "beforeprint", () => {
      this.pace.settle();
      this.draw();
    }); // paper gets what was drawn last
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

  // Where it looks from, how it looks from there, and what else moves it: see Sight.
  setAngled(angled: AngledView): void {
    this.sight.setAngled(angled);
    this.frame.request();
  }
  setAnatomy(anatomy: Anatomy): void {
    this.sight.setAnatomy(anatomy);
    this.frame.request();
  }
  setZoomEnabled(enabled: boolean): void {
    this.sight.setZoomEnabled(enabled);
  }
  view(preset: CameraPreset): void {
    this.sight.view(preset);
    this.frame.request();
  }
  near(point: PointMm): void {
    this.sight.near(point);
    this.frame.request();
  }
  look(): Look {
    return this.sight.look();
  }
  setLook(look: Look): void {
    this.sight.setLook(look);
    this.frame.request();
  }
  rotate(azimuthRad: number, polarRad: number): void {
    this.sight.rotate(azimuthRad, polarRad);
    this.frame.request();
  }
  zoom(factor: number): void {
    this.sight.zoom(factor);
    this.frame.request();
  }

  setMode(mode: ColorMode): void {
    this.heat.value = mode === "deviation" ? 1 : 0;
    this.frame.request();
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
    this.sight.follow(this.bur.position);
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
    setDrawing(this.renderer, this.pace.effort);
    this.renderer.setSize(width, height, false);
    this.sight.resize(width, height);
    this.frame.request();
  }

  // What is under a point of the canvas, in CSS pixels from its top left corner.
  pick(x: number, y: number): SurfacePoint | undefined {
    const pointer = new Vector2((2 * x) / this.canvas.clientWidth - 1, 1 - (2 * y) / this.canvas.clientHeight);
    const ray = new Raycaster();
    ray.setFromCamera(pointer, this.sight.camera);
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
    const sight = this.sight.away;
    this.section.update(this.centre, this.radius, sight, this.parts);
    this.ghost?.drawn.section.update(this.centre, this.radius, sight, this.ghost.drawn.parts);
    this.renderer.render(this.scene, this.sight.camera);
    this.drawn((point) => this.project(point), this.centre.toArray(), this.radius);
  }

  // CSS pixels from the canvas's top left corner, and depth.
  private project(point: PointMm): PointMm {
    const at = new Vector3(...point).project(this.sight.camera);
    return [((at.x + 1) / 2) * this.canvas.clientWidth, ((1 - at.y) / 2) * this.canvas.clientHeight, at.z];
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
