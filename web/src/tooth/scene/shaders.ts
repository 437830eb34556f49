import { kContourStepMm, kDeviationRangeMm } from "../deviation_scale";
import { kTissues } from "../tissue_color";
import { kCutFlag, kMaxStained, kStainSteps } from "./stain";
import { type Matrix, unit } from "./vec";

// What vertices and pixels of a tooth are made of. Two lamps hang at the camera and shine at the scene's origin; a
// third light comes from everywhere. Their sizes are such that π lights a matt surface fully.

const kAround = 1.3;
const kLamps = [
  { at: [-0.6, 0.9, 0.9], light: 1.9 },
  { at: [1, -0.3, 0.6], light: 0.45 },
] as const;
const kMatt = 0.3; // how much rougher what was cut is
const kGlossShare = 0.03; // what the gloss adds where light is worked out at the vertices

const glsl = (value: number) => value.toFixed(6);

// Where each lamp is seen from the scene's origin, in the camera's frame. The same for a whole picture: a shader would
// work it out for each vertex and pixel.
export const lampWays = (view: Matrix): number[] =>
  kLamps.flatMap(({ at: [x, y, z] }) => unit([x - view[12]!, y - view[13]!, z - view[14]!]));
const kLampWays = `
uniform vec3 wayTo[${kLamps.length}];
`;
// CUT: what lies before a plane is not drawn.
const kCutVertex = `
#ifdef CUT
uniform vec4 plane;
out float vBehind;
#endif
`;
const kCutFragment = `
#ifdef CUT
in float vBehind;
uniform vec3 toSlice[3];
uniform sampler2D slice;
uniform vec3 inside;
vec3 onCut() {
  vec3 at = vec3(gl_FragCoord.xy, 1.0);
  float away = dot(toSlice[2], at);
  if (away == 0.0) return inside;
  vec4 found = texture(slice, vec2(dot(toSlice[0], at), dot(toSlice[1], at)) / away);
  return found.a > 0.0 ? found.rgb / found.a : inside;
}
#endif
`;
const kDiscard = `
#ifdef CUT
  if (vBehind < 0.0) discard;
#endif
`;
// TISSUE, HEAT: the colours are those of the tissues, or of the deviation. Whatever is handed from vertices to pixels
// takes time for each triangle, so only what is needed is.
const kScale = `
uniform sampler2D scale;
uniform vec3 untouched;
in vec2 vDeviation;
vec3 onScale(float mm) { return texture(scale, vec2(0.5 + 0.5 * mm / ${glsl(kDeviationRangeMm)}, 0.5)).rgb; }
`;
// The palette ends with the stain of fissures; `tissue` is that of stain.ts, `own` that of looks.ts.
const kTissueColor = `
uniform vec3 palette[${kTissues + 1}];
vec3 tissueColor(float tissue, vec4 own) {
  int code = int(tissue + 0.5) % ${kCutFlag};
  return mix(mix(palette[code % 8], own.rgb * own.rgb, own.a), palette[${kTissues}], ${glsl(kMaxStained / kStainSteps)} * float(code / 8));
}
`;

export const kFullVertex = `
${kCutVertex}
in vec3 position;
in vec3 normal;
in float tissue;
in vec2 deviation;
in vec4 own;
uniform float translucent;
out float vMatt;
uniform mat4 projection;
uniform mat4 view;
uniform mat4 model;
${kTissueColor}
out vec3 vNormal;
out vec3 vPlace;
#ifdef HEAT
out vec2 vDeviation;
#else
out vec3 vColor;
#endif
void main() {
  vec4 place = view * model * vec4(position, 1.0);
  vNormal = mat3(view) * mat3(model) * normal;
  vPlace = place.xyz;
#ifdef HEAT
  vDeviation = deviation;
#else
  vColor = tissueColor(tissue, vec4(own.rgb, own.a * translucent));
#endif
  vMatt = step(${glsl(kCutFlag - 0.5)}, tissue);
#ifdef CUT
  vBehind = dot(plane, vec4(position, 1.0));
#endif
  gl_Position = projection * place;
}`;

// Gloss by Trowbridge and Reitz with the height-correlated shadowing of Smith (Heitz, "Understanding the
// masking-shadowing function in microfacet-based BRDFs", 2014) and Schlick's Fresnel term. The deviation has a thin
// line at every contour step: not at zero, and not where it hardly changes, because there noise alone would draw it.
export const kFullFragment = `
${kCutFragment}
${kLampWays}
in vec3 vNormal;
in vec3 vPlace;
in float vMatt;
uniform float roughness;
uniform float metal;
out vec4 pixel;

vec3 linear(vec3 color) { return mix(color / 12.92, pow((color + 0.055) / 1.055, vec3(2.4)), step(0.04045, color)); }
vec3 shown(vec3 color) { return mix(12.92 * color, 1.055 * pow(color, vec3(1.0 / 2.4)) - 0.055, step(0.0031308, color)); }

#ifdef HEAT
${kScale}
vec3 ownColor() {
  if (vDeviation.y < 0.5) return untouched;
  float mm = vDeviation.x / vDeviation.y;
  float level = mm / ${glsl(kContourStepMm)};
  float slope = fwidth(level);
  float line = abs(fract(level - 0.5) - 0.5) / max(slope, 1e-4);
  float strength = 0.45 * step(0.5, abs(level)) * smoothstep(0.05, 0.14, slope) * (1.0 - smoothstep(0.4, 1.2, line));
  return linear(onScale(mm)) * (1.0 - strength);
}
#else
in vec3 vColor;
vec3 ownColor() { return vColor; }
#endif

vec3 lit(vec3 color, vec3 n, vec3 eye, float rough, vec3 way, float light) {
  vec3 half_ = normalize(way + eye);
  float nl = clamp(dot(n, way), 0.0, 1.0), nv = clamp(dot(n, eye), 0.0, 1.0);
  float nh = clamp(dot(n, half_), 0.0, 1.0), vh = clamp(dot(eye, half_), 0.0, 1.0);
  float a2 = rough * rough * rough * rough;
  float bend = nh * nh * (a2 - 1.0) + 1.0;
  float facets = a2 / (${glsl(Math.PI)} * bend * bend);
  float seen = 0.5 / max(nl * sqrt(a2 + (1.0 - a2) * nv * nv) + nv * sqrt(a2 + (1.0 - a2) * nl * nl), 1e-6);
  vec3 straight = mix(vec3(0.04), color, metal);
  vec3 fresnel = straight + (1.0 - straight) * pow(1.0 - vh, 5.0);
  return light * nl * (color * (1.0 - metal) / ${glsl(Math.PI)} + fresnel * facets * seen);
}

void main() {
${kDiscard}
#ifdef CUT
  if (!gl_FrontFacing) { pixel = vec4(onCut(), 1.0); return; }
#endif
  vec3 color = ownColor();
#ifdef HEAT
  // A colour of the scale is a value: light would make another value of it.
  if (vDeviation.y >= 0.5) { pixel = vec4(shown(color), 1.0); return; }
#endif
  vec3 n = normalize(vNormal), eye = normalize(-vPlace);
  vec3 bend = max(abs(dFdx(n)), abs(dFdy(n)));
  float rough = min(1.0, roughness + ${glsl(kMatt)} * vMatt + max(max(bend.x, bend.y), bend.z));
  vec3 sum = ${glsl(kAround / Math.PI)} * color * (1.0 - metal);
${kLamps.map(({ light }, i) => `  sum += lit(color, n, eye, rough, wayTo[${i}], ${glsl(light)});\n`).join("")}
  pixel = vec4(shown(sum), 1.0);
}`;

// With light worked out at the vertices, so that a pixel costs little: about a third of the time on a processor. No
// contour lines, no gloss. Colours are those of the screen, which takes powers: the product of the powers is the power
// of the product. SHIFT: mm outwards.
export const kQuickVertex = `
${kCutVertex}
${kLampWays}
#ifndef SHIFT
#define SHIFT 0.0
#endif
in vec3 position;
in vec3 normal;
in float tissue;
in vec2 deviation;
uniform mat4 view;
uniform mat4 picture;
${kTissueColor}
#ifdef TISSUE
out vec3 vColor;
#else
out float vLight;
#endif
#ifdef HEAT
out vec2 vDeviation;
#endif
void main() {
  vec3 n = mat3(view) * normal;
  float light = pow(${glsl(kAround / Math.PI + kGlossShare)}
${kLamps.map(({ light }, i) => `    + ${glsl(light / Math.PI)} * max(0.0, dot(n, wayTo[${i}]))`).join("\n")}, 1.0 / 2.2);
#ifdef TISSUE
  vColor = light * tissueColor(tissue, vec4(0.0));
#else
  vLight = light;
#endif
#ifdef HEAT
  vDeviation = deviation;
#endif
#ifdef CUT
  vBehind = dot(plane, vec4(position, 1.0));
#endif
  gl_Position = picture * vec4(position + SHIFT * normal, 1.0);
}`;

export const kQuickFragment = `
${kCutFragment}
#ifdef HEAT
${kScale}
in float vLight;
vec3 ownColor() { return vDeviation.y < 0.5 ? vLight * untouched : onScale(vDeviation.x / vDeviation.y); }
#else
in vec3 vColor;
vec3 ownColor() { return vColor; }
#endif
out vec4 pixel;
void main() {
${kDiscard}
  vec3 color = ownColor();
#ifdef CUT
  if (!gl_FrontFacing) color = onCut();
#endif
  pixel = vec4(color, 1.0);
}`;

// A bur over colours that are values: clear but for its outline, where the surface turns away from the eye.
export const kGlassFragment = `
in vec3 vNormal;
in vec3 vPlace;
uniform vec4 tint;
out vec4 pixel;
void main() {
  float turned = 1.0 - abs(dot(normalize(vNormal), normalize(vPlace)));
  if (turned < 0.6) discard;
  pixel = vec4(tint.rgb, tint.a * smoothstep(0.6, 0.9, turned));
}`;

export const kGhostFragment = `
${kCutFragment}
uniform vec4 tint;
in float vLight;
out vec4 pixel;
void main() {
${kDiscard}
  pixel = vec4(tint.rgb * vLight, tint.a);
}`;

// The whole picture, `position` in −1 … 1.
export const kStripeVertex = `
in vec3 position;
void main() { gl_Position = vec4(position.xy, 0.0, 1.0); }`;
export const kStripeFragment = `
uniform vec4 tint;
uniform float width;
out vec4 pixel;
void main() {
  if (fract((gl_FragCoord.x + gl_FragCoord.y) / width) > 0.5) discard;
  pixel = tint;
}`;

// One colour, without light. `dash`: mm drawn, and left out, along a line; 0: all of it.
export const kPlainVertex = `
in vec3 position;
in float along;
uniform mat4 projection;
uniform mat4 view;
uniform mat4 model;
out float vAlong;
void main() {
  vAlong = along;
  gl_Position = projection * view * model * vec4(position, 1.0);
}`;
export const kPlainFragment = `
uniform vec4 tint;
uniform float dash;
in float vAlong;
out vec4 pixel;
void main() {
  if (dash > 0.0 && fract(vAlong / (2.0 * dash)) > 0.5) discard;
  pixel = tint;
}`;
