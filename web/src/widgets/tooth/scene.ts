import {
  AmbientLight, BufferAttribute, BufferGeometry, Color, DataTexture, DirectionalLight, Group, LatheGeometry, Line, LineBasicMaterial, LinearFilter,
  Mesh, MeshBasicMaterial, MeshStandardMaterial, PerspectiveCamera, Raycaster, Scene, SphereGeometry, Spherical,
  SRGBColorSpace, Vector2, Vector3, WebGLRenderer,
} from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";
import type { Surface } from "../../api/surface";
import type { BlockMesh } from "../../api/tooth_mesh";
import { Disposables } from "../../base/disposables";
import { FrameScheduler } from "../../base/frame";
import type { Look } from "../../base/moment_link";
import { deviationScalePixels, kContourStepMm, kDeviationRangeMm, kUntouchedColor } from "./deviation_scale";
import type { FilmPose, FilmScreen } from "./film";
import { tissueColor } from "./tissue";
import { TriangleGrid } from "./triangle_grid";

export type ColorMode = "tissue" | "deviation";
export type CameraPreset = "angled" | "occlusal" | "buccal" | "mesial";
export type PointMm = readonly [number, number, number];

// How to look into what was cut: from where, and at what.
export interface AngledView {
  readonly direction: PointMm;
  readonly centre: PointMm | undefined;         // undefined: the middle of the tooth
}

export interface SurfacePoint {
  readonly tissue: number;
  readonly deviationMm: number | undefined;   // NaN: untouched; undefined: nothing to compare with
  readonly pointMm: PointMm;                  // where exactly
}

// From what is looked at towards the camera; scene frame. "angled" is given by who shows the tooth.
const kDirections: Readonly<Record<Exclude<CameraPreset, "angled">, PointMm>> = {
  occlusal: [0, -0.001, 1],
  buccal: [0, 1, 0.25],
  mesial: [1, 0, 0.25],
};
const kFieldOfViewDeg = 28;
const kMargin = 1.02;                          // of the bounding sphere, so that nothing touches the edge
const kAngledCloser = 0.8;                     // of the distance at which the whole tooth is in view
const kMarkerRadiusMm = 0.2;
const kSamePlaceMm = 1e-3;
const kMinPolar = 0.001;                       // Spherical turns over at the poles

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
  private readonly tooth: Mesh<BufferGeometry, MeshStandardMaterial>;
  private grid: TriangleGrid | undefined;       // made when something is first looked up
  private readonly marker: Mesh;
  private readonly film = new Group();          // the tooth while it is played back, in blocks
  private readonly filmMaterial = new MeshStandardMaterial({ vertexColors: true, roughness: 0.55, metalness: 0 });
  private readonly blocks = new Map<number, Mesh>();
  private bur: Mesh | undefined;
  private readonly trail: Line;
  private readonly centre = new Vector3();
  private radius = 1;

  constructor(private readonly canvas: HTMLCanvasElement, private readonly surface: Surface, private readonly angled: AngledView,
              private readonly drawn: (project: (point: PointMm) => PointMm, centre: PointMm, radius: number) => void) {
    this.renderer = new WebGLRenderer({ canvas, antialias: true, alpha: true, powerPreference: "low-power" });
    this.cleanup.add(() => this.renderer.dispose());
    this.tooth = new Mesh(toothGeometry(surface), this.toothMaterial());
    this.marker = toolMarker();
    this.trail = new Line(new BufferGeometry(), new LineBasicMaterial({ color: 0x101418, depthTest: false, transparent: true, opacity: 0.55 }));
    this.trail.renderOrder = 1;
    this.trail.frustumCulled = false;
    this.film.visible = false;
    this.cleanup.add(() => { for (const block of this.blocks.values()) block.geometry.dispose(); this.filmMaterial.dispose(); });
    this.scene.add(this.tooth, this.film, this.trail, this.marker, this.camera, new AmbientLight(0xffffff, 1.3));
    this.addLights();

    const sphere = this.tooth.geometry.boundingSphere;
    if (sphere !== null) {
      this.centre.copy(sphere.center);
      this.radius = Math.max(sphere.radius, 0.5);
    }
    this.camera.up.set(0, 0, 1);
    this.controls = this.orbit();
    this.cleanup.add(() => this.frame.cancel());
    this.cleanup.listen(window, "beforeprint", () => this.draw());  // paper gets what was drawn last
    this.view("angled");
  }

  dispose(): void {
    this.cleanup.dispose();
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
    this.frame.request();
  }

  setBlock(index: number, mesh: BlockMesh | undefined): void {
    const before = this.blocks.get(index);
    if (before !== undefined) {
      this.film.remove(before);
      before.geometry.dispose();
      this.blocks.delete(index);
    }
    if (mesh !== undefined) {
      const made = new Mesh(blockGeometry(mesh), this.filmMaterial);
      this.blocks.set(index, made);
      this.film.add(made);
    }
    if (this.film.visible) this.frame.request();
  }
  showFilm(on: boolean): void {
    this.film.visible = on;
    this.tooth.visible = !on;
    this.frame.request();
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
    }
    this.frame.request();
  }

  // What lies over the picture has moved without it.
  redraw(): void {
    this.frame.request();
  }

  resize(width: number, height: number): void {
    if (width < 1 || height < 1) return;
    const previous = this.fitDistance();
    this.renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    this.zoom(this.fitDistance() / previous);
  }

  view(preset: CameraPreset): void {
    const angled = preset === "angled";
    const direction = new Vector3(...(angled ? this.angled.direction : kDirections[preset])).normalize();
    const target = angled && this.angled.centre !== undefined ? new Vector3(...this.angled.centre) : this.centre;
    this.controls.target.copy(target);
    this.camera.position.copy(target).addScaledVector(direction, this.fitDistance() * (angled ? kAngledCloser : 1));
    this.controls.update();
    this.frame.request();
  }

  look(): Look {
    const away = this.camera.position.clone().sub(this.controls.target);
    const { theta, phi, radius } = new Spherical().setFromCartesianCoords(away.x, away.z, -away.y);
    return { azimuthRad: theta, polarRad: phi, distance: radius / this.fitDistance(), atCut: this.controls.target.distanceTo(this.centre) > kSamePlaceMm };
  }
  setLook({ azimuthRad, polarRad, distance, atCut }: Look): void {
    this.view(atCut ? "angled" : "occlusal");   // for what is looked at
    this.moveCamera((offset) => { offset.set(distance * this.fitDistance(), Math.min(Math.max(polarRad, kMinPolar), Math.PI - kMinPolar), azimuthRad); });
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
    this.grid ??= new TriangleGrid(this.surface.positionMm, this.surface.triangle);
    const hit = this.grid.firstHit(ray.ray.origin.toArray(), ray.ray.direction.toArray());
    const vertex = hit === undefined ? undefined : this.surface.triangle[3 * hit.triangle];
    if (hit === undefined || vertex === undefined) return undefined;
    return { tissue: this.surface.tissue[vertex] ?? 0, deviationMm: this.surface.deviationMm?.[vertex], pointMm: hit.at };
  }

  private draw(): void {
    this.renderer.render(this.scene, this.camera);
    this.drawn((point) => this.project(point), this.centre.toArray(), this.radius);
  }

  // CSS pixels from the canvas's top left corner, and depth.
  private project(point: PointMm): PointMm {
    const at = new Vector3(...point).project(this.camera);
    return [((at.x + 1) / 2) * this.canvas.clientWidth, ((1 - at.y) / 2) * this.canvas.clientHeight, at.z];
  }

  private fitDistance(): number {
    const half = (kFieldOfViewDeg * Math.PI) / 360;
    const narrow = Math.min(1, this.camera.aspect);
    return (this.radius * kMargin) / Math.sin(Math.atan(Math.tan(half) * narrow));
  }

  private moveCamera(change: (offset: Spherical) => void): void {
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
    controls.minDistance = this.radius * 0.8;
    controls.maxDistance = this.radius * 12;
    // A finger may still scroll the page over the picture; sideways it turns the tooth.
    this.canvas.style.touchAction = "pan-y";
    controls.addEventListener("change", () => this.frame.request());
    this.cleanup.add(() => controls.dispose());
    return controls;
  }

  private addLights(): void {
    const key = new DirectionalLight(0xffffff, 1.9);
    key.position.set(-0.6, 0.9, 0.9);
    const fill = new DirectionalLight(0xffffff, 0.45);
    fill.position.set(1, -0.3, 0.6);
    this.camera.add(key, fill);
  }

  private toothMaterial(): MeshStandardMaterial {
    const material = new MeshStandardMaterial({ vertexColors: true, roughness: 0.55, metalness: 0 });
    const scale = new DataTexture(deviationScalePixels(256), 256, 1);
    scale.colorSpace = SRGBColorSpace;
    scale.minFilter = scale.magFilter = LinearFilter;
    scale.needsUpdate = true;
    material.onBeforeCompile = (shader) => {
      shader.uniforms["heat"] = this.heat;
      shader.uniforms["scale"] = { value: scale };
      shader.uniforms["untouched"] = { value: new Color(kUntouchedColor) };
      shader.vertexShader = withDeviationAttribute(shader.vertexShader);
      shader.fragmentShader = withDeviationColor(shader.fragmentShader);
    };
    this.cleanup.add(() => {
      scale.dispose();
      material.dispose();
    });
    return material;
  }
}

function toothGeometry(surface: Surface): BufferGeometry {
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new BufferAttribute(surface.positionMm, 3));
  geometry.setAttribute("normal", new BufferAttribute(surface.normal, 4, true));
  geometry.setAttribute("color", new BufferAttribute(tissueColors(surface.tissue), 3, true));
  geometry.setAttribute("deviation", new BufferAttribute(deviationPairs(surface), 2));
  geometry.setIndex(new BufferAttribute(surface.triangle, 1));
  geometry.computeBoundingSphere();
  return geometry;
}

function blockGeometry({ positionMm, normal, tissue, triangle }: BlockMesh): BufferGeometry {
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new BufferAttribute(positionMm, 3));
  geometry.setAttribute("normal", new BufferAttribute(normal, 4, true));
  geometry.setAttribute("color", new BufferAttribute(tissueColors(tissue), 3, true));
  geometry.setIndex(new BufferAttribute(triangle, 1));
  return geometry;
}

// A body of revolution, its tip at the origin and its shank along +z.
function burMesh(outline: readonly (readonly [number, number])[]): Mesh {
  // Closed at both ends, also where the outline ends at a radius.
  const closed = [[outline[0]![0], 0] as const, ...outline, [outline.at(-1)![0], 0] as const];
  const geometry = new LatheGeometry(closed.map(([place, radius]) => new Vector2(radius, place)), 32);
  geometry.rotateX(Math.PI / 2);
  return new Mesh(geometry, new MeshStandardMaterial({ color: 0x8a94a0, roughness: 0.35, metalness: 0.6 }));
}

function tissueColors(tissue: Uint8Array): Uint8Array<ArrayBuffer> {
  const table = Array.from({ length: 256 }, (_, i) => {
    const linear = new Color(tissueColor(i));
    return [linear.r * 255, linear.g * 255, linear.b * 255];
  });
  const colors = new Uint8Array(3 * tissue.length);
  tissue.forEach((value, i) => colors.set(table[value]!, 3 * i));
  return colors;
}

// (deviation or 0, 1 where compared): interpolated, x / y is the deviation right up to the border of
// what was cut, where NaN would eat a row of triangles.
function deviationPairs(surface: Surface): Float32Array<ArrayBuffer> {
  const pairs = new Float32Array(2 * surface.tissue.length);
  surface.deviationMm?.forEach((value, i) => {
    if (!Number.isNaN(value)) pairs.set([value, 1], 2 * i);
  });
  return pairs;
}

function withDeviationAttribute(shader: string): string {
  return shader
    .replace("#include <common>", "#include <common>\nattribute vec2 deviation;\nvarying vec2 vDeviation;")
    .replace("#include <begin_vertex>", "#include <begin_vertex>\nvDeviation = deviation;");
}

// The scale's colour, with a thin line at every contour step: not at zero, and not where the deviation
// hardly changes, because there noise alone would draw it.
function withDeviationColor(shader: string): string {
  return shader
    .replace("#include <common>", `#include <common>
uniform float heat;
uniform sampler2D scale;
uniform vec3 untouched;
varying vec2 vDeviation;
vec3 deviationColor() {
  if (vDeviation.y < 0.5) return untouched;
  float mm = vDeviation.x / vDeviation.y;
  vec3 color = texture2D(scale, vec2(0.5 + 0.5 * mm / ${kDeviationRangeMm.toFixed(3)}, 0.5)).rgb;
  float level = mm / ${kContourStepMm.toFixed(3)};
  float slope = fwidth(level);
  float line = abs(fract(level - 0.5) - 0.5) / max(slope, 1e-4);
  float strength = 0.45 * step(0.5, abs(level)) * smoothstep(0.05, 0.14, slope) * (1.0 - smoothstep(0.4, 1.2, line));
  return color * (1.0 - strength);
}`)
    .replace("#include <color_fragment>",
             "#include <color_fragment>\nif (heat > 0.5) diffuseColor.rgb = deviationColor();");
}

function toolMarker(): Mesh {
  const over = { depthTest: false, transparent: true };
  const rim = new Mesh(new SphereGeometry(kMarkerRadiusMm * 1.45, 24, 16), new MeshBasicMaterial({ color: 0xffffff, ...over }));
  const core = new Mesh(new SphereGeometry(kMarkerRadiusMm, 24, 16), new MeshBasicMaterial({ color: 0x0b7a4b, ...over }));
  rim.renderOrder = 2;
  core.renderOrder = 3;
  rim.add(core);
  rim.visible = false;
  return rim;
}
