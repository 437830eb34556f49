import {
  Color,
  DataTexture,
  DoubleSide,
  FrontSide,
  LinearFilter,
  NoColorSpace,
  type Plane,
  ShaderMaterial,
} from "three";
import { deviationScalePixels, kDeviationRangeMm } from "./deviation_scale";

// The tooth's colours with light worked out at the vertices, so that a pixel costs little: about a
// third of the time of the elaborate material on a processor. No contour lines, no gloss. The lamps
// are those of ToothScene: an intensity of π is 1 here.

export interface QuickLook {
  readonly heat: { readonly value: number }; // shared with the elaborate material
  readonly untouched: string;
  readonly inside: string; // colour of a cut
}

// SHIFT: mm outwards.
export const kQuickVertex = `
attribute vec2 deviation;
varying vec2 vDeviation;
varying vec3 vColor;
varying float vLight;
#include <clipping_planes_pars_vertex>
const float kGamma = 1.0 / 2.2;
void main() {
  vec3 n = normalize(normalMatrix * normal);
  // The lamps hang at the camera and point at the scene's origin. 0.03 stands for the gloss.
  vec3 origin = viewMatrix[3].xyz;
  float light = 0.44 + 0.6 * max(0.0, dot(n, normalize(vec3(-0.6, 0.9, 0.9) - origin))) + 0.14 * max(0.0, dot(n, normalize(vec3(1.0, -0.3, 0.6) - origin)));
  // The screen takes powers: the product of the powers is the power of the product.
  vLight = pow(light, kGamma);
  vColor = pow(color, vec3(kGamma));
  vDeviation = deviation;
  vec4 mvPosition = modelViewMatrix * vec4(position + float(SHIFT) * normal, 1.0);
  gl_Position = projectionMatrix * mvPosition;
  #include <clipping_planes_vertex>
}`;

const kFragment = `
uniform float heat;
uniform sampler2D scale;
uniform vec3 untouched;
uniform vec3 inside;
varying vec2 vDeviation;
varying vec3 vColor;
varying float vLight;
#include <clipping_planes_pars_fragment>
void main() {
  #include <clipping_planes_fragment>
  vec3 color = vColor;
  if (heat > 0.5) color = vDeviation.y < 0.5 ? untouched : texture2D(scale, vec2(0.5 + 0.5 * vDeviation.x / vDeviation.y / ${kDeviationRangeMm.toFixed(3)}, 0.5)).rgb;
  color *= vLight;
  #ifdef DOUBLE_SIDED
  if (!gl_FrontFacing) color = inside;
  #endif
  gl_FragColor = vec4(color, 1.0);
}`;

export function quickMaterial({ heat, untouched, inside }: QuickLook): ShaderMaterial {
  const scale = new DataTexture(deviationScalePixels(256), 256, 1);
  scale.colorSpace = NoColorSpace;
  scale.minFilter = scale.magFilter = LinearFilter;
  scale.needsUpdate = true;
  const material = new ShaderMaterial({
    vertexShader: kQuickVertex,
    fragmentShader: kFragment,
    vertexColors: true,
    clipping: true,
    defines: { SHIFT: 0 },
    uniforms: {
      heat,
      scale: { value: scale },
      untouched: { value: asShown(untouched) },
      inside: { value: asShown(inside) },
    },
  });
  material.addEventListener("dispose", () => scale.dispose());
  return material;
}

// In screen colours, which the shader writes.
export function asShown(hex: string): Color {
  return new Color().setHex(Number.parseInt(hex.slice(1), 16), NoColorSpace);
}

export function cutBy(
  material: { clippingPlanes: Plane[] | null; side: number; needsUpdate: boolean },
  plane: Plane | undefined,
): void {
  material.clippingPlanes = plane === undefined ? null : [plane];
  // Behind the plane one looks at the inside of the surface: painted flat it is the cut.
  material.side = plane === undefined ? FrontSide : DoubleSide;
  material.needsUpdate = true;
}
