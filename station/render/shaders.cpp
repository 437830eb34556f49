#include "station/render/shaders.h"

namespace enamel::station::render {

const char* const kSolidVertex = R"(#version 330 core
layout(location = 0) in vec3 position_mm;
layout(location = 1) in vec3 normal;
layout(location = 2) in uint material;
uniform mat4 view_from_model, clip_from_view;
uniform vec3 colours[16];
uniform float gloss[16];
out vec3 local, view_position, view_normal, albedo;
out float shine;
flat out uint kind;
void main() {
  vec4 p = view_from_model * vec4(position_mm, 1.0);
  local = position_mm;
  view_position = p.xyz;
  view_normal = mat3(view_from_model) * normal;
  albedo = colours[material];
  shine = gloss[material];
  kind = material;
  gl_Position = clip_from_view * p;
}
)";

// Key light over the left shoulder, fill from the right, sky and bounce; all fixed to the camera,
// so that a cavity reads the same from every side. Material 8 is the bur's head: flutes by angle.
const char* const kSolidFragment = R"(#version 330 core
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
  vec3 to_eye = normalize(-view_position);
  vec3 base = albedo;
  if (kind == 8u) {
    float turn = atan(local.y, local.x) + spin + 1.4 * local.z / max(flute_height_mm, 0.2);
    float blade = 0.5 + 0.5 * sin(8.0 * turn);
    base *= 0.55 + 0.6 * smoothstep(0.25, 0.85, blade);
  }
  base = mix(base, ghost_colour, ghostly);
  vec3 key = normalize(vec3(-0.55, 0.75, 0.55)), fill = normalize(vec3(0.8, 0.1, 0.45));
  float d = max((dot(n, key) + 0.15) / 1.15, 0.0);
  float f = max(dot(n, fill), 0.0);
  float sky = 0.5 + 0.5 * dot(n, up_in_view);
  vec3 light = vec3(0.86, 0.83, 0.78) * d + vec3(0.16, 0.18, 0.22) * f +
               mix(vec3(0.15, 0.12, 0.11), vec3(0.30, 0.31, 0.33), sky);
  float s = pow(max(dot(n, normalize(key + to_eye)), 0.0), 48.0);
  float rim = pow(1.0 - max(dot(n, to_eye), 0.0), 3.0);
  vec3 c = base * light + shine * (0.55 * s + 0.10 * rim) * vec3(1.0, 0.98, 0.95);
  colour = vec4(pow(clamp(c, 0.0, 1.0), vec3(1.0 / 2.2)), opacity);
  normal_out = vec4(n * 0.5 + 0.5, 1.0);
}
)";

const char* const kFullScreenVertex = R"(#version 330 core
out vec2 uv;
void main() {
  uv = vec2((gl_VertexID << 1) & 2, gl_VertexID & 2);
  gl_Position = vec4(uv * 2.0 - 1.0, 0.0, 1.0);
}
)";

// Ambient occlusion in screen space: the share of points in the half ball over a pixel that lie
// behind what is drawn. Directions turn from pixel to pixel in a 4 x 4 tile; composing averages it.
const char* const kOcclusionFragment = R"(#version 330 core
in vec2 uv;
uniform sampler2D depth, normals;
uniform mat4 clip_from_view;
uniform float radius_mm;
uniform vec3 kernel[20];
uniform int samples;
layout(location = 0) out vec4 occlusion;
vec3 ViewAt(vec2 at) {
  float ndc = texture(depth, at).r * 2.0 - 1.0;
  float z = -clip_from_view[3][2] / (ndc + clip_from_view[2][2]);
  return vec3((at * 2.0 - 1.0) * -z / vec2(clip_from_view[0][0], clip_from_view[1][1]), z);
}
void main() {
  if (texture(depth, uv).r >= 1.0) {
    occlusion = vec4(1.0);
    return;
  }
  vec3 p = ViewAt(uv), n = normalize(texture(normals, uv).xyz * 2.0 - 1.0);
  ivec2 tile = ivec2(gl_FragCoord.xy) & 3;
  float angle = 6.2831853 * float((tile.x * 4 + tile.y) * 7 % 16) / 16.0;
  vec3 turned = vec3(cos(angle), sin(angle), 0.0);
  vec3 t = normalize(turned - n * dot(turned, n) + vec3(0.0, 0.0, 1e-4));
  mat3 frame = mat3(t, cross(n, t), n);
  float hidden = 0.0;
  for (int i = 0; i < samples; ++i) {
    vec3 q = p + n * (0.02 * radius_mm) + frame * kernel[i] * radius_mm;
    vec4 c = clip_from_view * vec4(q, 1.0);
    float seen = ViewAt(c.xy / c.w * 0.5 + 0.5).z;
    float near = smoothstep(0.0, 1.0, radius_mm / max(abs(p.z - seen), 1e-4));
    hidden += seen > q.z + 0.015 * radius_mm ? near : 0.0;
  }
  occlusion = vec4(1.0 - hidden / float(samples));
}
)";

// Averages the 4 x 4 tile, not across edges in depth.
const char* const kBlurFragment = R"(#version 330 core
uniform sampler2D occlusion, depth;
uniform mat4 clip_from_view;
layout(location = 0) out vec4 smooth_occlusion;
float ZAt(vec2 at) {
  return -clip_from_view[3][2] / (texture(depth, at).r * 2.0 - 1.0 + clip_from_view[2][2]);
}
void main() {
  vec2 size = vec2(textureSize(occlusion, 0));
  float z = ZAt(gl_FragCoord.xy / size), sum = 0.0, weights = 0.0;
  for (int y = -2; y < 2; ++y) {
    for (int x = -2; x < 2; ++x) {
      vec2 at = (gl_FragCoord.xy + vec2(x, y)) / size;
      float w = 1.0 / (0.05 + abs(ZAt(at) - z));
      sum += w * texture(occlusion, at).r;
      weights += w;
    }
  }
  smooth_occlusion = vec4(sum / weights);
}
)";

const char* const kComposeFragment = R"(#version 330 core
in vec2 uv;
uniform sampler2D solid, occlusion, depth;
uniform mat4 clip_from_view;
uniform int occluded;
layout(location = 0) out vec4 colour;
float ZAt(vec2 at) {
  return -clip_from_view[3][2] / (texture(depth, at).r * 2.0 - 1.0 + clip_from_view[2][2]);
}
void main() {
  vec4 c = texture(solid, uv);
  if (c.a == 0.0 || occluded == 0) {
    float open_sky = occluded == 0 ? 0.94 : 1.0;
    float from_middle = length(uv - vec2(0.5, 0.55));
    vec3 sky = mix(vec3(0.235, 0.25, 0.275), vec3(0.085, 0.09, 0.10), smoothstep(0.05, 0.85, from_middle));
    colour = vec4(mix(sky, c.rgb * open_sky, c.a), 1.0);
    return;
  }
  // Bilinear between the four occlusion pixels around, as far as they are at the same depth.
  vec2 size = vec2(textureSize(occlusion, 0)), at = uv * size - 0.5, f = fract(at);
  float z = ZAt(uv), sum = 0.0, weights = 0.0;
  for (int i = 0; i < 4; ++i) {
    vec2 step = vec2(i & 1, i >> 1), corner = (floor(at) + step + 0.5) / size;
    vec2 share = mix(1.0 - f, f, step);
    float w = (share.x * share.y + 1e-3) / (0.05 + abs(ZAt(corner) - z));
    sum += w * texture(occlusion, corner).r;
    weights += w;
  }
  float open = mix(1.0, sum / weights, c.a);
  // Occluded light is warm: it has bounced off tooth.
  vec3 shade = mix(vec3(0.20, 0.13, 0.10), vec3(1.0), smoothstep(0.05, 0.95, open));
  float vignette = length(uv - vec2(0.5, 0.55));
  vec3 behind = mix(vec3(0.235, 0.25, 0.275), vec3(0.085, 0.09, 0.10), smoothstep(0.05, 0.85, vignette));
  colour = vec4(mix(behind, c.rgb / max(c.a, 1e-3) * shade, c.a), 1.0);
}
)";

// Where the bur keeps the key light off: the nearest point of the way to the light to the axis of
// the cutting part (tip to neck) and of the shank (neck to top), softer the farther the bur is; and
// a darker seam where it is near, whatever the light. Exact for capsules.
const char* const kShadowFragment = R"(#version 330 core
in vec2 uv;
uniform sampler2D depth;
uniform mat4 clip_from_view;
uniform vec3 to_light, tip, neck, top;
uniform float head_radius_mm, reach_mm, side_mm;
layout(location = 0) out vec4 light_left;
// Of the ray from p: x, the least distance to the segment; y, how far along the ray that is.
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
