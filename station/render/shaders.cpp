#include "station/render/shaders.h"

namespace enamel::station::render {

const char* const kLooks = R"(#version 330 core
uniform vec3 colours[16];
uniform float gloss[16];
// Colour, as its square root, and gloss. 12 to 212 is the gingiva: from 12 by 13 to 14. 213 to 232 is
// the rubber dam, 233 a tooth, which has a look of its own.
vec4 Coloured(vec3 colour, float shine) { return vec4(sqrt(colour), shine); }
vec4 Looks(uint material, vec4 own) {
  if (material >= 233u) return own;
  if (material >= 213u) return Coloured(colours[15], gloss[15]);
  if (material < 12u) return Coloured(colours[material], gloss[material]);
  float at = float(material - 12u) / 100.0;
  int first = at < 1.0 ? 12 : 13;
  float part = at - float(first - 12);
  return Coloured(mix(colours[first], colours[first + 1], part),
                  mix(gloss[first], gloss[first + 1], part));
}
// The dark of the mouth and the rest of the sheet fade into the background.
float Opacity(uint material) {
  if (material >= 233u) return 1.0;
  if (material >= 213u) return 1.0 - smoothstep(0.0, 1.0, float(material - 213u) / 19.0);
  return material < 12u ? 1.0 : 1.0 - smoothstep(1.2, 1.9, float(material - 12u) / 100.0);
}
)";

const char* const kSolidVertex = R"(
layout(location = 0) in vec3 position_mm;
layout(location = 1) in vec3 normal;
layout(location = 2) in uint material;
layout(location = 3) in vec4 look;
uniform mat4 view_from_model, clip_from_view;
uniform vec4 before;
out vec3 local, view_position, view_normal, albedo;
out float shine;
flat out uint kind;
void main() {
  vec4 p = view_from_model * vec4(position_mm, 1.0);
  local = position_mm;
  view_position = p.xyz;
  view_normal = mat3(view_from_model) * normal;
  vec4 looks = Looks(material, look);
  albedo = looks.rgb * looks.rgb;
  shine = looks.a;
  kind = material;
  gl_Position = clip_from_view * p;
  gl_ClipDistance[0] = dot(before, p);
}
)";

// Key light over the left shoulder, fill from the right, sky and bounce; all fixed to the camera,
// so that a cavity looks the same from every side. `base` is linear; the result is in the display's
// encoding.
const char* const kLit = R"(#version 330 core
vec3 Lit(vec3 base, float shine, vec3 n, vec3 to_eye, vec3 up_in_view) {
  vec3 key = normalize(vec3(-0.55, 0.75, 0.55)), fill = normalize(vec3(0.8, 0.1, 0.45));
  float d = max((dot(n, key) + 0.15) / 1.15, 0.0);
  float f = max(dot(n, fill), 0.0);
  float sky = 0.5 + 0.5 * dot(n, up_in_view);
  vec3 light = vec3(0.86, 0.83, 0.78) * d + vec3(0.16, 0.18, 0.22) * f +
               mix(vec3(0.15, 0.12, 0.11), vec3(0.30, 0.31, 0.33), sky);
  float s = max(dot(n, normalize(key + to_eye)), 0.0), s2 = s * s, s4 = s2 * s2, s8 = s4 * s4;
  float s48 = s8 * s8 * s8 * s8 * s8 * s8;
  float side = 1.0 - max(dot(n, to_eye), 0.0), rim = side * side * side;
  // What is wet or polished mirrors the lamp beside.
  float s96 = s48 * s48, s384 = s96 * s96 * s96 * s96, film = max(2.0 * shine - 1.0, 0.0);
  vec3 c = base * light + (shine * (0.45 * s48 + 0.10 * rim) + film * s384) * vec3(1.0, 0.98, 0.95);
  return pow(clamp(c, 0.0, 1.0), vec3(1.0 / 2.2));
}
)";

// Material 8 is the bur's head: flutes by angle.
const char* const kSolidFragment = R"(
in vec3 local, view_position, view_normal, albedo;
in float shine;
flat in uint kind;
uniform vec3 up_in_view;
uniform float spin, opacity, flute_height_mm, ghostly;
uniform vec3 ghost_colour;
layout(location = 0) out vec4 colour;
layout(location = 1) out vec4 normal_out;
void main() {
  vec3 n = normalize(view_normal);
  vec3 base = albedo;
  if (kind == 8u) {
    float turn = atan(local.y, local.x) + spin + 1.4 * local.z / max(flute_height_mm, 0.2);
    float blade = 0.5 + 0.5 * sin(8.0 * turn);
    base *= 0.55 + 0.6 * smoothstep(0.25, 0.85, blade);
  }
  base = mix(base, ghost_colour, ghostly);
  colour = vec4(Lit(base, shine, n, normalize(-view_position), up_in_view), opacity);
  normal_out = vec4(n * 0.5 + 0.5, 1.0);
}
)";

// The tooth is most of the triangles, many smaller than the block of pixels a processor shades at
// once. So each costs as little as possible: the inputs of lighting are stored, and light is
// computed when composing, once for each visible pixel.
const char* const kToothVertex = R"(
layout(location = 0) in vec3 position_mm;
layout(location = 1) in vec3 normal;
layout(location = 2) in uint material;
layout(location = 3) in vec4 look;
uniform mat4 view_from_model, clip_from_view;
uniform vec4 before;
out vec4 view_normal_and_opacity;
out vec4 root_albedo_and_shine;
void main() {
  view_normal_and_opacity = vec4(mat3(view_from_model) * normal, Opacity(material));
  root_albedo_and_shine = Looks(material, look);
  vec4 p = view_from_model * vec4(position_mm, 1.0);
  gl_Position = clip_from_view * p;
  gl_ClipDistance[0] = dot(before, p);
}
)";
const char* const kToothFragment = R"(#version 330 core
in vec4 view_normal_and_opacity;
in vec4 root_albedo_and_shine;
layout(location = 0) out vec4 albedo;
layout(location = 1) out vec4 normal_out;
void main() {
  albedo = root_albedo_and_shine;
  normal_out = vec4(view_normal_and_opacity.xyz * 0.5 + 0.5, view_normal_and_opacity.w);
}
)";

const char* const kFullScreenVertex = R"(#version 330 core
out vec2 uv;
void main() {
  uv = vec2((gl_VertexID << 1) & 2, gl_VertexID & 2);
  gl_Position = vec4(uv * 2.0 - 1.0, 0.0, 1.0);
}
)";

// Ambient occlusion in screen space: the share of points in the half ball over a pixel that are
// behind the surface drawn. Directions turn from pixel to pixel in a 4 x 4 tile; composing averages
// it. Also stores the pixel's depth in view, mm.
const char* const kOcclusionFragment = R"(#version 330 core
in vec2 uv;
uniform sampler2D depth, normals;
uniform mat4 clip_from_view;
uniform float radius_mm;
uniform vec3 kernel[20];
uniform int samples;
layout(location = 0) out vec4 occlusion;
float ZAt(ivec2 at) {
  return -clip_from_view[3][2] / (texelFetch(depth, at, 0).r * 2.0 - 1.0 + clip_from_view[2][2]);
}
void main() {
  ivec2 size = textureSize(depth, 0), here = ivec2(uv * vec2(size));
  if (texelFetch(depth, here, 0).r >= 1.0) {
    occlusion = vec4(1.0, -1e4, 0.0, 0.0);
    return;
  }
  vec2 slope = vec2(clip_from_view[0][0], clip_from_view[1][1]);
  float z = ZAt(here);
  vec3 p = vec3((uv * 2.0 - 1.0) * -z / slope, z);
  vec3 n = normalize(texelFetch(normals, here, 0).xyz * 2.0 - 1.0);
  ivec2 tile = ivec2(gl_FragCoord.xy) & 3;
  float angle = 6.2831853 * float((tile.x * 4 + tile.y) * 7 % 16) / 16.0;
  vec3 turned = vec3(cos(angle), sin(angle), 0.0);
  vec3 t = normalize(turned - n * dot(turned, n) + vec3(0.0, 0.0, 1e-4));
  mat3 frame = mat3(t, cross(n, t), n) * radius_mm;
  vec3 from = p + n * (0.02 * radius_mm);
  vec2 half_size = 0.5 * vec2(size);
  float hidden = 0.0;
  for (int i = 0; i < samples; ++i) {
    vec3 q = from + frame * kernel[i];
    ivec2 at = ivec2((q.xy * slope / -q.z + 1.0) * half_size);
    float seen = ZAt(clamp(at, ivec2(0), size - 1));
    float near = smoothstep(0.0, 1.0, radius_mm / max(abs(p.z - seen), 1e-4));
    hidden += seen > q.z + 0.015 * radius_mm ? near : 0.0;
  }
  occlusion = vec4(1.0 - hidden / float(samples), z, 0.0, 0.0);
}
)";

// Averages the 4 x 4 tile, not across edges in depth.
const char* const kBlurFragment = R"(#version 330 core
uniform sampler2D occlusion;
layout(location = 0) out vec4 smooth_occlusion;
void main() {
  ivec2 here = ivec2(gl_FragCoord.xy), last = textureSize(occlusion, 0) - 1;
  float z = texelFetch(occlusion, here, 0).g, sum = 0.0, weights = 0.0;
  if (z < -9e3) {
    smooth_occlusion = vec4(1.0, z, 0.0, 0.0);
    return;
  }
  for (int y = -2; y < 2; ++y) {
    for (int x = -2; x < 2; ++x) {
      vec2 there = texelFetch(occlusion, clamp(here + ivec2(x, y), ivec2(0), last), 0).rg;
      float w = 1.0 / (0.05 + abs(there.g - z));
      sum += w * there.r;
      weights += w;
    }
  }
  smooth_occlusion = vec4(sum / weights, z, 0.0, 0.0);
}
)";

const char* const kComposeFragment = R"(
in vec2 uv;
uniform sampler2D albedo, normals, occlusion, depth;
uniform mat4 clip_from_view;
uniform vec3 up_in_view;
uniform int occluded;
layout(location = 0) out vec4 colour;
// Bilinear between the four surrounding occlusion pixels of the same depth.
float Open(float z) {
  ivec2 size = textureSize(occlusion, 0);
  vec2 at = uv * vec2(size) - 0.5, f = fract(at);
  float sum = 0.0, weights = 0.0;
  for (int i = 0; i < 4; ++i) {
    ivec2 step = ivec2(i & 1, i >> 1);
    vec2 there = texelFetch(occlusion, clamp(ivec2(floor(at)) + step, ivec2(0), size - 1), 0).rg;
    vec2 share = mix(1.0 - f, f, vec2(step));
    float w = (share.x * share.y + 1e-3) / (0.05 + abs(there.g - z));
    sum += w * there.r;
    weights += w;
  }
  return sum / weights;
}
void main() {
  ivec2 here = ivec2(gl_FragCoord.xy);
  float d = texelFetch(depth, here, 0).r;
  if (d >= 1.0) discard;
  vec4 kept = texelFetch(albedo, here, 0);
  vec4 facing = texelFetch(normals, here, 0);
  vec3 n = normalize(facing.xyz * 2.0 - 1.0);
  vec2 slope = vec2(clip_from_view[0][0], clip_from_view[1][1]);
  vec3 to_eye = normalize(vec3((1.0 - uv * 2.0) / slope, 1.0));
  vec3 lit = Lit(kept.rgb * kept.rgb, kept.a, n, to_eye, up_in_view);
  if (occluded == 0) {
    colour = vec4(0.94 * lit, facing.w);
    return;
  }
  float z = -clip_from_view[3][2] / (d * 2.0 - 1.0 + clip_from_view[2][2]);
  // Occluded light is warm: it has bounced off tooth.
  colour = vec4(lit * mix(vec3(0.20, 0.13, 0.10), vec3(1.0), smoothstep(0.05, 0.95, Open(z))), facing.w);
}
)";

const char* const kBackgroundFragment = R"(#version 330 core
in vec2 uv;
layout(location = 0) out vec4 colour;
void main() {
  float from_middle = length(uv - vec2(0.5, 0.55));
  colour = vec4(mix(vec3(0.235, 0.25, 0.275), vec3(0.085, 0.09, 0.10),
                    smoothstep(0.05, 0.85, from_middle)), 1.0);
}
)";

// A mirror shows at each pixel what its mirrored eye sees there: a plane mirror's image lies behind
// it on the same line of sight. It is a little darker than what it
// shows, with a sheen of its own; the rim of the glass is ground.
const char* const kMirrorFragment = R"(#version 330 core
in vec3 local, view_position, view_normal, albedo;
in float shine;
uniform sampler2D reflection;
uniform float radius_mm;
layout(location = 0) out vec4 colour;
void main() {
  vec3 seen = texelFetch(reflection, ivec2(gl_FragCoord.xy), 0).rgb * vec3(0.88, 0.90, 0.91) + vec3(0.05, 0.055, 0.06);
  float ground = smoothstep(radius_mm - 0.35, radius_mm - 0.15, length(local.xy));
  colour = vec4(mix(seen, vec3(0.62, 0.65, 0.68), 0.8 * ground), 1.0);
}
)";

// The bur's shadow of the key light: the nearest point of the ray to the light to the axis of the
// cutting part (tip to neck) and of the shank (neck to top), softer the farther the bur is. A
// darker seam where it is near, for any light. Exact for capsules.
const char* const kShadowFragment = R"(#version 330 core
in vec2 uv;
uniform sampler2D depth;
uniform mat4 clip_from_view;
uniform vec3 to_light, tip, neck, top;
uniform float head_radius_mm, reach_mm, side_mm;
layout(location = 0) out vec4 light_left;
// For the ray from p: x, the least distance to the segment; y, its distance along the ray.
vec2 ToSegment(vec3 p, vec3 a, vec3 b) {
  vec3 v = b - a, w = p - a;
  float uv = dot(to_light, v), vv = dot(v, v), uw = dot(to_light, w), vw = dot(v, w);
  float s = clamp((vw - uv * uw) / max(vv - uv * uv, 1e-6), 0.0, 1.0);
  float t = max(dot(a + s * v - p, to_light), 0.0);
  s = clamp(dot(p + t * to_light - a, v) / vv, 0.0, 1.0);
  return vec2(length(p + t * to_light - a - s * v), t);
}
float Lit(vec3 p, vec3 a, vec3 b, float radius) {
  vec2 near = ToSegment(p, a, b);
  float soft = 0.06 + 0.22 * near.y;
  float shade = 1.0 - smoothstep(radius - soft, radius + soft, near.x);
  return 1.0 - 0.55 * shade * (1.0 - smoothstep(0.3 * reach_mm, reach_mm, near.y));
}
void main() {
  float d = texture(depth, uv).r;
  light_left = vec4(1.0);
  if (d >= 1.0) return;
  float z = -clip_from_view[3][2] / (d * 2.0 - 1.0 + clip_from_view[2][2]);
  vec3 p = vec3((uv * 2.0 - 1.0) * -z / vec2(clip_from_view[0][0], clip_from_view[1][1]), z);
  float shank = min(0.8, head_radius_mm);
  float lit = min(Lit(p, tip, neck, head_radius_mm), Lit(p, neck, top, shank));
  float s = clamp(dot(p - tip, neck - tip) / max(dot(neck - tip, neck - tip), 1e-6), 0.0, 1.0);
  float beside = distance(p, mix(tip, neck, s)) - head_radius_mm;
  lit *= 1.0 - 0.35 * (1.0 - smoothstep(0.0, side_mm, beside));
  light_left = vec4(vec3(lit), 1.0);
}
)";

}  // namespace enamel::station::render
