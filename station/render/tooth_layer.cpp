#include "station/render/tooth_layer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <utility>

#include "station/render/materials.h"
#include "station/render/shaders.h"

namespace enamel::station::render {
namespace {

constexpr int kKernelSize = 20;  // the shader's array; a lower quality uses the first of them
// Reach of the occlusion's blur, over pixels at half size.
constexpr int kBlurReach_px = 8;

// Points of the half ball over +z, denser near its middle.
std::array<glm::vec3, kKernelSize> OcclusionKernel() {
  std::array<glm::vec3, kKernelSize> kernel;
  // A fixed seed: pictures of one state are the same to the byte.
  std::mt19937 random(5);
  auto unit = [&] { return static_cast<float>(random()) / 4294967296.0f; };
  for (int i = 0; i < kKernelSize; ++i) {
    // Near and far points alternate, so that the first few reach as far as all.
    int rank = i * 7 % kKernelSize;
    float turn = 6.2831853f * unit(), z = std::sqrt(0.05f + 0.95f * unit()),
          rho = std::sqrt(1 - z * z);
    float share = (static_cast<float>(rank) + 0.5f) / kKernelSize;
    kernel[static_cast<size_t>(i)] =
        glm::vec3(rho * std::cos(turn), rho * std::sin(turn), z) * (0.08f + 0.92f * share * share);
  }
  return kernel;
}

// Pixels of a target at half the size that a rectangle of the whole one touches.
PixelRect Halved(const PixelRect& part) {
  return {part.x0 / 2, part.y0 / 2, (part.x1 + 1) / 2, (part.y1 + 1) / 2};
}

bool MayBeSeen(const Bounds& bounds, const Eye& from) {
  const glm::mat4 &view = from.view_from_scene, &clip = from.clip_from_view;
  glm::vec3 p(view * glm::vec4(bounds.middle_mm, 1));
  for (int axis = 0; axis < 2; ++axis) {
    // Sides of the view: |clip p| <= -z. The side's plane is not normalised: the root turns it into
    // a distance.
    float slope = clip[axis][axis], outside = slope * std::fabs(p[axis]) + p.z;
    if (outside > bounds.radius_mm * std::sqrt(slope * slope + 1)) return false;
  }
  if (from.mirrored && glm::dot(from.before, glm::vec4(p, 1)) < -bounds.radius_mm) return false;
  return MayFace(bounds, glm::vec3(glm::inverse(view)[3]));
}

}  // namespace

void Scissor(const PixelRect& part) {
  glEnable(GL_SCISSOR_TEST);
  glScissor(part.x0, part.y0, part.x1 - part.x0, part.y1 - part.y0);
}

void SeeWith(const Eye& eye) {
  glEnable(GL_CULL_FACE);
  glCullFace(eye.mirrored ? GL_FRONT : GL_BACK);
  eye.mirrored ? glEnable(GL_CLIP_DISTANCE0) : glDisable(GL_CLIP_DISTANCE0);
}

ToothLayer::Programs::Programs()
    : kept({kLooks, kToothVertex}, {kToothFragment}),
      occlusion({kFullScreenVertex}, {kOcclusionFragment}),
      blur({kFullScreenVertex}, {kBlurFragment}),
      compose({kFullScreenVertex}, {kLit, kComposeFragment}),
      background({kFullScreenVertex}, {kBackgroundFragment}) {
  glGenVertexArrays(1, &empty_array);
  kept.Use();
  SetMaterials(kept);
  occlusion.Use();
  occlusion.Set("kernel", std::span<const glm::vec3>(OcclusionKernel()));
  occlusion.Set("radius_mm", kOcclusionRadius_mm);
  occlusion.Set("depth", 0);
  occlusion.Set("normals", 1);
  blur.Use();
  blur.Set("occlusion", 0);
  compose.Use();
  compose.Set("albedo", 0);
  compose.Set("normals", 1);
  compose.Set("occlusion", 2);
  compose.Set("depth", 3);
}

bool ToothLayer::Resize(int width, int height) {
  if (solids_ && width == solids_->width() && height == solids_->height()) return false;
  auto target = [](int w, int h, std::initializer_list<GLenum> colours, bool depth, GLenum filter) {
    return std::make_unique<Target>(w, h, colours, depth, filter);
  };
  const int half_width = (width + 1) / 2, half_height = (height + 1) / 2;
  solids_ = target(width, height, {GL_RGBA8, GL_RGBA8}, true, GL_LINEAR);
  occluded_ = target(half_width, half_height, {GL_RG32F}, false, GL_NEAREST);
  blurred_ = target(half_width, half_height, {GL_RG32F}, false, GL_NEAREST);
  composed_ = target(width, height, {GL_RGBA8}, false, GL_NEAREST);
  empty_ = target(width, height, {GL_RGBA8}, false, GL_NEAREST);
  DrawBackground();
  drawn_eye_.reset();
  return true;
}

void ToothLayer::DrawBackground() {
  empty_->Bind();
  glDisable(GL_SCISSOR_TEST);
  glDisable(GL_DEPTH_TEST);
  glDisable(GL_BLEND);
  programs_.background.Use();
  glBindVertexArray(programs_.empty_array);
  glDrawArrays(GL_TRIANGLES, 0, 3);
}

ToothLayer::Stale ToothLayer::StalePart(const Eye& eye, const Quality& quality,
                                        const PixelRect& wanted) {
  const int w = width(), h = height();
  work_.whole =
      drawn_eye_ != eye || !(drawn_quality_ == quality) || wanted.Within(drawn_part_) != wanted;
  work_.triangles_drawn = 0;
  Stale stale;
  if (work_.whole) {
    stale.solids = stale.around = drawn_part_ = wanted;
  } else {
    float reach = quality.occlusion_samples > 0 ? kOcclusionRadius_mm : 0;
    for (const Bounds& b : changed_) {
      auto ball = [&](float radius) {
        return AroundBall(eye.view_from_scene, eye.clip_from_view, w, h, b.middle_mm, radius);
      };
      stale.solids = stale.solids.Around(ball(b.radius_mm));
      stale.around = stale.around.Around(ball(b.radius_mm + reach));
    }
    // Pixels of the half-size occlusion, and its blur, reach over the edge.
    constexpr int kEdge = 1;
    stale.solids = stale.solids.Grown(kEdge, w, h).Within(drawn_part_);
    stale.around = stale.around.Grown(kBlurReach_px, w, h).Within(drawn_part_);
  }
  // The current drawing includes all changes so far.
  changed_.clear();
  drawn_eye_ = eye;
  drawn_quality_ = quality;
  return stale;
}

void ToothLayer::Draw(std::span<const Body* const> bodies, const Eye& eye, const Quality& quality,
                      const PixelRect& wanted) {
  const Stale stale = StalePart(eye, quality, wanted);
  if (stale.solids.empty()) return;
  DrawTooth(bodies, eye, quality.coarse, stale.solids);
  if (quality.occlusion_samples > 0) DrawOcclusion(eye, quality, stale.around.Within(tooth_));
  Compose(eye, quality, stale.around);
  glDisable(GL_SCISSOR_TEST);
}

// Front to back, so that hidden parts cost no light.
void ToothLayer::DrawTooth(std::span<const Body* const> bodies, const Eye& eye, bool coarse,
                           const PixelRect& part) {
  solids_->Bind();
  Scissor(part);
  glClearColor(0, 0, 0, 0);
  glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
  glDisable(GL_BLEND);
  glEnable(GL_DEPTH_TEST);
  SeeWith(eye);
  programs_.kept.Use();
  programs_.kept.Set("clip_from_view", eye.clip_from_view);
  programs_.kept.Set("view_from_model", eye.view_from_scene);
  programs_.kept.Set("before", eye.before);
  std::vector<std::pair<float, const Body*>> seen;
  tooth_ = {};
  for (const Body* body : bodies) {
    if (!MayBeSeen(body->bounds, eye)) continue;
    PixelRect here = AroundBall(eye.view_from_scene, eye.clip_from_view, width(), height(),
                                body->bounds.middle_mm, body->bounds.radius_mm);
    tooth_ = tooth_.Around(here);
    if (!here.Meets(part)) continue;
    glm::vec4 middle = eye.view_from_scene * glm::vec4(body->bounds.middle_mm, 1);
    seen.emplace_back(-middle.z, body);
  }
  // The rim around it, where the occlusion's pixels and their blur reach over the edge.
  tooth_ = tooth_.Grown(kBlurReach_px, width(), height());
  std::sort(seen.begin(), seen.end());
  for (const auto& [depth, body] : seen) work_.triangles_drawn += body->triangles.Draw(coarse);
  SeeWith({});
}

void ToothLayer::DrawOcclusion(const Eye& eye, const Quality& quality, const PixelRect& part) {
  occluded_->Bind();
  Scissor(Halved(part));
  glDisable(GL_DEPTH_TEST);
  solids_->BindDepth(0);
  solids_->BindColour(1, 1);
  programs_.occlusion.Use();
  programs_.occlusion.Set("clip_from_view", eye.clip_from_view);
  programs_.occlusion.Set("samples", std::min(quality.occlusion_samples, kKernelSize));
  glBindVertexArray(programs_.empty_array);
  glDrawArrays(GL_TRIANGLES, 0, 3);
  blurred_->Bind();
  occluded_->BindColour(0, 0);
  programs_.blur.Use();
  glDrawArrays(GL_TRIANGLES, 0, 3);
}

void ToothLayer::Compose(const Eye& eye, const Quality& quality, const PixelRect& part) {
  Scissor(part);
  empty_->CopyColourTo(*composed_);
  composed_->Bind();
  Scissor(part.Within(tooth_));
  glDisable(GL_DEPTH_TEST);
  glEnable(GL_BLEND);
  glBlendFuncSeparate(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA, GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
  solids_->BindColour(0, 0);
  solids_->BindColour(1, 1);
  blurred_->BindColour(2, 0);
  solids_->BindDepth(3);
  programs_.compose.Use();
  programs_.compose.Set("clip_from_view", eye.clip_from_view);
  programs_.compose.Set("up_in_view", eye.up_in_view());
  programs_.compose.Set("occluded", quality.occlusion_samples > 0 ? 1 : 0);
  glBindVertexArray(programs_.empty_array);
  glDrawArrays(GL_TRIANGLES, 0, 3);
  glDisable(GL_BLEND);
}

}  // namespace enamel::station::render
