import {
  Box3,
  type Camera,
  DirectionalLight,
  BufferAttribute,
  BufferGeometry,
  Color,
  DataTexture,
  LatheGeometry,
  LinearFilter,
  Mesh,
  MeshBasicMaterial,
  MeshStandardMaterial,
  SphereGeometry,
  SRGBColorSpace,
  Vector2,
} from "three";
import type { Surface } from "../../api/surface";
import type { Disposables } from "../../base/disposables";
import { deviationScalePixels, kContourStepMm, kDeviationRangeMm, kUntouchedColor } from "./deviation_scale";
import type { Cuttable } from "./section";
import { tissueColors } from "./tissue_colors";

// What a scene of a tooth is drawn with: geometry, materials, bur and tool.

const kMarkerRadiusMm = 0.2;
export const kInsideColor = "#b98a5e";

export function toothGeometry(surface: Surface): BufferGeometry {
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new BufferAttribute(surface.positionMm, 3));
  geometry.setAttribute("normal", new BufferAttribute(surface.normal, 4, true));
  geometry.setAttribute("color", new BufferAttribute(tissueColors(surface.tissue), 3, true));
  geometry.setAttribute("deviation", new BufferAttribute(deviationPairs(surface), 2));
  geometry.setIndex(new BufferAttribute(surface.triangle, 1));
  geometry.computeBoundingSphere();
  return geometry;
}

// (deviation or 0, 1 where compared): interpolated, x / y is the deviation right up to the border
// of what was cut, where NaN would eat a row of triangles.
function deviationPairs(surface: Surface): Float32Array<ArrayBuffer> {
  const pairs = new Float32Array(2 * surface.tissue.length);
  surface.deviationMm?.forEach((value, i) => {
    if (!Number.isNaN(value)) pairs.set([value, 1], 2 * i);
  });
  return pairs;
}

// A body of revolution, its tip at the origin and its shank along +z.
export function burMesh(outline: readonly (readonly [number, number])[]): Mesh {
  // Closed at both ends, also where the outline ends at a radius.
  const closed = [[outline[0]![0], 0] as const, ...outline, [outline.at(-1)![0], 0] as const];
  const geometry = new LatheGeometry(
    closed.map(([place, radius]) => new Vector2(radius, place)),
    32,
  );
  geometry.rotateX(Math.PI / 2);
  // After what is translucent, which would else be drawn over it.
  const bur = new Mesh(
    geometry,
    new MeshStandardMaterial({ color: 0x8a94a0, roughness: 0.35, metalness: 0.6, transparent: true }),
  );
  bur.renderOrder = 0.5;
  return bur;
}

export function toolMarker(): Mesh {
  const over = { depthTest: false, transparent: true };
  const rim = new Mesh(
    new SphereGeometry(kMarkerRadiusMm * 1.45, 24, 16),
    new MeshBasicMaterial({ color: 0xffffff, ...over }),
  );
  const core = new Mesh(
    new SphereGeometry(kMarkerRadiusMm, 24, 16),
    new MeshBasicMaterial({ color: 0x0b7a4b, ...over }),
  );
  rim.renderOrder = 2;
  core.renderOrder = 3;
  rim.add(core);
  rim.visible = false;
  return rim;
}

// Tissue colours, or the scale of the deviation where `heat` is 1. `cleanup` frees it.
export function toothMaterial(heat: { value: number }, cleanup: Disposables): MeshStandardMaterial {
  const material = new MeshStandardMaterial({ vertexColors: true, roughness: 0.55, metalness: 0 });
  const scale = new DataTexture(deviationScalePixels(256), 256, 1);
  scale.colorSpace = SRGBColorSpace;
  scale.minFilter = scale.magFilter = LinearFilter;
  scale.needsUpdate = true;
  material.onBeforeCompile = (shader) => {
    shader.uniforms["heat"] = heat;
    shader.uniforms["scale"] = { value: scale };
    shader.uniforms["untouched"] = { value: new Color(kUntouchedColor) };
    shader.uniforms["inside"] = { value: new Color(kInsideColor) };
    shader.vertexShader = withDeviationAttribute(shader.vertexShader);
    shader.fragmentShader = withDeviationColor(shader.fragmentShader);
  };
  cleanup.add(() => {
    scale.dispose();
    material.dispose();
  });
  return material;
}

function withDeviationAttribute(shader: string): string {
  return shader
    .replace("#include <common>", "#include <common>\nattribute vec2 deviation;\nvarying vec2 vDeviation;")
    .replace("#include <begin_vertex>", "#include <begin_vertex>\nvDeviation = deviation;");
}

// The scale's colour, with a thin line at every contour step: not at zero, and not where the
// deviation hardly changes, because there noise alone would draw it.
function withDeviationColor(shader: string): string {
  return (
    shader
      .replace(
        "#include <common>",
        `#include <common>
uniform float heat;
uniform sampler2D scale;
uniform vec3 untouched;
uniform vec3 inside;
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
}`,
      )
      .replace(
        "#include <color_fragment>",
        "#include <color_fragment>\nif (heat > 0.5) diffuseColor.rgb = deviationColor();",
      )
      // Without light: the inside of the surface stands for the plane.
      .replace(
        "#include <opaque_fragment>",
        "#include <opaque_fragment>\n#ifdef DOUBLE_SIDED\nif (!gl_FrontFacing) gl_FragColor.rgb = inside;\n#endif",
      )
  );
}

// They move with the camera.
export function addLights(camera: Camera): void {
  const key = new DirectionalLight(0xffffff, 1.9);
  key.position.set(-0.6, 0.9, 0.9);
  const fill = new DirectionalLight(0xffffff, 0.45);
  fill.position.set(1, -0.3, 0.6);
  camera.add(key, fill);
}

// A fixed surface, as one part.
export function wholeOf(surface: Surface): () => Iterable<Cuttable> {
  const box = new Box3().setFromArray(surface.positionMm);
  return () => [{ mesh: surface, box }];
}
