#include "station/render/picture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <random>

#include "station/render/revolve.h"
#include "station/render/shaders.h"

namespace enamel::station::render {
namespace {

constexpr int kKernelSize = 20;  // the shader's array; a lower quality uses the first of them
// Reach of ambient occlusion: about half a cavity's width.
constexpr float kOcclusionRadius_mm = 1.6f;
// Reach of its blur, over pixels at half size.
constexpr int kBlurReach_px = 8;

glm::vec3 Linear(int r, int g, int b) {
  return glm::pow(glm::vec3(r, g, b) / 255.0f, glm::vec3(2.2f));
}

// By cutting::Tissue, then Material.
std::array<glm::vec3, 16> Colours() {
  std::array<glm::vec3, 16> c;
  c.fill(Linear(255, 0, 255));
  c[1] = Linear(242, 234, 214);  // enamel: ivory
  c[2] = Linear(226, 187, 116);  // dentin: yellower
  c[3] = Linear(186, 46, 48);    // pulp
  c[4] = Linear(112, 74, 44);    // caries
  c[5] = Linear(190, 196, 206);  // filling
  c[6] = Linear(226, 222, 212);  // gypsum
  c[7] = Linear(222, 214, 196);  // neighbour
  c[kBurHead] = Linear(150, 170, 205);
  c[kBurShank] = Linear(176, 186, 204);
  c[kForceArrow] = Linear(40, 205, 190);
  c[kTargetLine] = Linear(20, 96, 235);
  return c;
}

std::array<float, 16> Gloss() {
  std::array<float, 16> g;
  g.fill(0.25f);
  g[1] = 0.55f;
  g[2] = 0.15f;
  g[kBurHead] = g[kBurShank] = 1.0f;
  g[kForceArrow] = g[kTargetLine] = 0.1f;
  return g;
}

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

TriangleBuffer& Fill(TriangleBuffer& buffer, const Shape& shape) {
  buffer.Upload(shape.vertices, shape.indices);
  return buffer;
}

// As in the shaders: over the left shoulder, in view.
const glm::vec3 kKeyLight = glm::normalize(glm::vec3(-0.55f, 0.75f, 0.55f));
// Length of a shadow, and its reach beside the bur.
constexpr float kShadowReach_mm = 5, kShadowSide_mm = 1.2f, kShankShadow_mm = 6;

void Scissor(const PixelRect& part) {
  glEnable(GL_SCISSOR_TEST);
  glScissor(part.x0, part.y0, part.x1 - part.x0, part.y1 - part.y0);
}

// Pixels of a target at half the size that a rectangle of the whole one touches.
PixelRect Halved(const PixelRect& part) {
  return {part.x0 / 2, part.y0 / 2, (part.x1 + 1) / 2, (part.y1 + 1) / 2};
}

// Radius of a line on the tooth: three pixels where a crown fills a window.
constexpr float kLineRadius_mm = 0.05f;

// Parts of a bur.
constexpr int kHead = 1, kShank = 2;

// Looking down the shank, which would then hide the cut.
bool SeenFromAbove(const PictureState& state) {
  glm::vec4 axis = state.view_from_scene * (*state.scene_from_bur)[2];
  return axis.z > 0.85f;
}

glm::vec3 UpInView(const PictureState& state) {
  return glm::vec3(state.view_from_scene * glm::vec4(0, 0, 1, 0));
}

// A frame whose +z is along `direction`.
glm::mat4 Along(const glm::vec3& from, const glm::vec3& direction) {
  glm::vec3 z = glm::normalize(direction);
  glm::vec3 x = glm::normalize(
      glm::cross(std::fabs(z.x) < 0.7f ? glm::vec3(1, 0, 0) : glm::vec3(0, 1, 0), z));
  return glm::mat4(glm::vec4(x, 0), glm::vec4(glm::cross(z, x), 0), glm::vec4(z, 0),
                   glm::vec4(from, 1));
}

}  // namespace

Picture::Picture(const cutting::Bur& bur, size_t group_count)
    : kept_(kToothVertex, {kToothFragment}),
      solid_(kSolidVertex, {kLit, kSolidFragment}),
      occlusion_(kFullScreenVertex, {kOcclusionFragment}),
      blur_(kFullScreenVertex, {kBlurFragment}),
      compose_(kFullScreenVertex, {kLit, kComposeFragment}),
      background_(kFullScreenVertex, {kBackgroundFragment}),
      shadow_(kFullScreenVertex, {kShadowFragment}),
      groups_(group_count),
      bur_height_mm_(static_cast<float>(bur.height_m() * 1000)),
      bur_radius_mm_(static_cast<float>(bur.radius_m * 1000)) {
  Fill(bur_head_, BurHeadShape(bur));
  Fill(bur_shank_, BurShankShape(bur));
  Fill(shaft_, ShaftShape());
  Fill(tip_, TipShape());
  glGenVertexArrays(1, &empty_array_);
  for (const Program* program : {&kept_, &solid_}) {
    program->Use();
    program->Set("colours", std::span<const glm::vec3>(Colours()));
    program->Set("gloss", std::span<const float>(Gloss()));
  }
  solid_.Set("ghost_colour", Linear(90, 150, 255));
  occlusion_.Use();
  occlusion_.Set("kernel", std::span<const glm::vec3>(OcclusionKernel()));
  occlusion_.Set("radius_mm", kOcclusionRadius_mm);
  occlusion_.Set("depth", 0);
  occlusion_.Set("normals", 1);
  blur_.Use();
  blur_.Set("occlusion", 0);
  compose_.Use();
  compose_.Set("albedo", 0);
  compose_.Set("normals", 1);
  compose_.Set("occlusion", 2);
  compose_.Set("depth", 3);
  shadow_.Use();
  shadow_.Set("depth", 0);
  shadow_.Set("to_light", kKeyLight);
}

void Picture::Replace(const GroupMesh& mesh) {
  auto& group = groups_[mesh.group];
  if (group && !mesh.same_surface) changed_.push_back(group->bounds);
  if (!group) group = std::make_unique<Group>();
  work_.triangles -= group->triangles.triangle_count();
  group->triangles.Upload(mesh.vertices, mesh.indices, mesh.coarse);
  work_.triangles += group->triangles.triangle_count();
  group->bounds = mesh.bounds;
  if (!mesh.same_surface) changed_.push_back(group->bounds);
}

Quality Picture::QualityNow(const PictureState& state, const Quality& wanted) {
  bool moved = last_view_ && *last_view_ != state.view_from_scene;
  last_view_ = state.view_from_scene;
  still_ = moved ? 0 : std::min(still_ + 1, kStillPictures);
  return wanted.lighter_turning && still_ < kStillPictures ? WhileTurning(wanted) : wanted;
}

bool Picture::MayBeSeen(const Bounds& bounds, const PictureState& state) const {
  const glm::mat4 &view = state.view_from_scene, &clip = state.clip_from_view;
  glm::vec3 p(view * glm::vec4(bounds.middle_mm, 1));
  for (int axis = 0; axis < 2; ++axis) {
    // Sides of the view: |clip p| <= -z. The side's plane is not normalised: the root turns it into
    // a distance.
    float slope = clip[axis][axis], outside = slope * std::fabs(p[axis]) + p.z;
    if (outside > bounds.radius_mm * std::sqrt(slope * slope + 1)) return false;
  }
  glm::vec3 eye(glm::inverse(view)[3]);
  return MayFace(bounds, eye);
}

void Picture::Resize(int width, int height, const Quality& quality) {
  auto scaled = [&](int n) {
    return std::max(1, static_cast<int>(std::lround(static_cast<float>(n) * quality.scale)));
  };
  int w = scaled(width), h = scaled(height);
  bool same = result_ && result_->width() == width && result_->height() == height &&
              solids_->width() == w && solids_->height() == h;
  if (same) return;
  auto target = [](int tw, int th, std::initializer_list<GLenum> colours, bool depth,
                   GLenum filter) {
    return std::make_unique<Target>(tw, th, colours, depth, filter);
  };
  solids_ = target(w, h, {GL_RGBA8, GL_RGBA8}, true, GL_LINEAR);
  occluded_ = target((w + 1) / 2, (h + 1) / 2, {GL_RG32F}, false, GL_NEAREST);
  blurred_ = target((w + 1) / 2, (h + 1) / 2, {GL_RG32F}, false, GL_NEAREST);
  composed_ = target(w, h, {GL_RGBA8}, false, GL_NEAREST);
  frame_ = target(w, h, {GL_RGBA8}, true, GL_LINEAR);
  result_ = target(width, height, {GL_RGBA8}, false, GL_NEAREST);
  empty_ = target(w, h, {GL_RGBA8}, false, GL_NEAREST);
  DrawBackground();
  drawn_view_ = drawn_clip_ = glm::mat4(0);
}

void Picture::DrawBackground() {
  empty_->Bind();
  glDisable(GL_SCISSOR_TEST);
  glDisable(GL_DEPTH_TEST);
  glDisable(GL_BLEND);
  background_.Use();
  glBindVertexArray(empty_array_);
  glDrawArrays(GL_TRIANGLES, 0, 3);
}

Picture::Stale Picture::StalePart(const PictureState& state, const Quality& quality) {
  int w = solids_->width(), h = solids_->height();
  work_.whole = drawn_view_ != state.view_from_scene || drawn_clip_ != state.clip_from_view ||
                !(drawn_quality_ == quality);
  work_.triangles_drawn = 0;
  work_.coarse = quality.coarse;
  Stale stale;
  if (work_.whole) {
    stale.solids = stale.around = PixelRect::Whole(w, h);
  } else {
    float reach = quality.occlusion_samples > 0 ? kOcclusionRadius_mm : 0;
    for (const Bounds& b : changed_) {
      auto ball = [&](float radius) {
        return AroundBall(state.view_from_scene, state.clip_from_view, w, h, b.middle_mm, radius);
      };
      stale.solids = stale.solids.Around(ball(b.radius_mm));
      stale.around = stale.around.Around(ball(b.radius_mm + reach));
    }
    // Pixels of the half-size occlusion, and its blur, reach over the edge.
    constexpr int kEdge = 1;
    stale.solids = stale.solids.Grown(kEdge, w, h);
    stale.around = stale.around.Grown(kBlurReach_px, w, h);
  }
  // The current drawing includes all changes so far.
  changed_.clear();
  drawn_view_ = state.view_from_scene;
  drawn_clip_ = state.clip_from_view;
  drawn_quality_ = quality;
  return stale;
}

void Picture::Draw(const PictureState& state, int width, int height, const Quality& wanted) {
  Quality quality = QualityNow(state, wanted);
  Resize(width, height, quality);
  Stale stale = StalePart(state, quality);
  if (!stale.solids.empty()) {
    DrawTooth(state, stale.solids);
    if (quality.occlusion_samples > 0) DrawOcclusion(state, quality, stale.around.Within(tooth_));
    Compose(state, quality, stale.around);
    glDisable(GL_SCISSOR_TEST);
  }
  CopyTooth();
  if (state.lines) DrawLines(state);
  if (state.scene_from_bur) {
    DrawShadow(state);
    DrawBurs(state);
  }
  DrawArrow(state);
  frame_->CopyColourTo(*result_);
}

void Picture::UseSolid(const PictureState& state) {
  glDisable(GL_BLEND);
  glEnable(GL_DEPTH_TEST);
  glEnable(GL_CULL_FACE);
  solid_.Use();
  solid_.Set("clip_from_view", state.clip_from_view);
  solid_.Set("view_from_model", state.view_from_scene);
  solid_.Set("up_in_view", UpInView(state));
  solid_.Set("spin", state.bur_spin);
  solid_.Set("flute_height_mm", bur_height_mm_);
  solid_.Set("opacity", 1.0f);
  solid_.Set("ghostly", 0.0f);
}

void Picture::UseTooth(const PictureState& state) {
  glDisable(GL_BLEND);
  glEnable(GL_DEPTH_TEST);
  glEnable(GL_CULL_FACE);
  kept_.Use();
  kept_.Set("clip_from_view", state.clip_from_view);
  kept_.Set("view_from_model", state.view_from_scene);
}

// Front to back, so that hidden parts cost no light.
void Picture::DrawTooth(const PictureState& state, const PixelRect& part) {
  solids_->Bind();
  Scissor(part);
  glClearColor(0, 0, 0, 0);
  glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
  UseTooth(state);
  int w = solids_->width(), h = solids_->height();
  std::vector<std::pair<float, const Group*>> seen;
  tooth_ = {};
  for (const auto& group : groups_) {
    if (!group || !MayBeSeen(group->bounds, state)) continue;
    PixelRect here = AroundBall(state.view_from_scene, state.clip_from_view, w, h,
                                group->bounds.middle_mm, group->bounds.radius_mm);
    tooth_ = tooth_.Around(here);
    if (!here.Meets(part)) continue;
    glm::vec4 middle = state.view_from_scene * glm::vec4(group->bounds.middle_mm, 1);
    seen.emplace_back(-middle.z, group.get());
  }
  // The rim around it, where the occlusion's pixels and their blur reach over the edge.
  tooth_ = tooth_.Grown(kBlurReach_px, w, h);
  std::sort(seen.begin(), seen.end());
  for (const auto& [depth, group] : seen) {
    work_.triangles_drawn += group->triangles.Draw(work_.coarse);
  }
}

void Picture::DrawOcclusion(const PictureState& state, const Quality& quality,
                            const PixelRect& part) {
  occluded_->Bind();
  Scissor(Halved(part));
  glDisable(GL_DEPTH_TEST);
  solids_->BindDepth(0);
  solids_->BindColour(1, 1);
  occlusion_.Use();
  occlusion_.Set("clip_from_view", state.clip_from_view);
  occlusion_.Set("samples", std::min(quality.occlusion_samples, kKernelSize));
  glBindVertexArray(empty_array_);
  glDrawArrays(GL_TRIANGLES, 0, 3);
  blurred_->Bind();
  occluded_->BindColour(0, 0);
  blur_.Use();
  glDrawArrays(GL_TRIANGLES, 0, 3);
}

void Picture::Compose(const PictureState& state, const Quality& quality, const PixelRect& part) {
  Scissor(part);
  empty_->CopyColourTo(*composed_);
  composed_->Bind();
  Scissor(part.Within(tooth_));
  glDisable(GL_DEPTH_TEST);
  solids_->BindColour(0, 0);
  solids_->BindColour(1, 1);
  blurred_->BindColour(2, 0);
  solids_->BindDepth(3);
  compose_.Use();
  compose_.Set("clip_from_view", state.clip_from_view);
  compose_.Set("up_in_view", UpInView(state));
  compose_.Set("occluded", quality.occlusion_samples > 0 ? 1 : 0);
  glBindVertexArray(empty_array_);
  glDrawArrays(GL_TRIANGLES, 0, 3);
}

void Picture::CopyTooth() {
  composed_->CopyColourTo(*frame_);
  solids_->CopyDepthTo(*frame_);
  frame_->Bind();
}

void Picture::SetLines(std::span<const surface::LineSegment> lines) {
  Fill(lines_, LineShape(lines, kLineRadius_mm));
}

void Picture::DrawLines(const PictureState& state) {
  if (lines_.triangle_count() == 0) return;
  UseSolid(state);
  lines_.Draw();
}

// The bur as two capsules, cutting part and shank, seen from the light and from beside the tooth.
void Picture::DrawShadow(const PictureState& state) {
  glm::mat4 view_from_bur = state.view_from_scene * *state.scene_from_bur;
  auto at = [&](float z) { return glm::vec3(view_from_bur * glm::vec4(0, 0, z, 1)); };
  float lift = std::min(bur_radius_mm_, 0.5f * bur_height_mm_);
  glm::vec3 tip = at(lift), neck = at(bur_height_mm_), top = at(bur_height_mm_ + kShankShadow_mm);
  int w = frame_->width(), h = frame_->height();
  PixelRect part;
  for (const glm::vec3& p : {tip, neck, top}) {
    for (float along : {0.0f, kShadowReach_mm}) {
      part = part.Around(AroundBall(glm::mat4(1), state.clip_from_view, w, h, p - along * kKeyLight,
                                    bur_radius_mm_ + kShadowSide_mm));
    }
  }
  if (part.empty()) return;
  Scissor(part);
  glDisable(GL_DEPTH_TEST);
  glEnable(GL_BLEND);
  glBlendFunc(GL_DST_COLOR, GL_ZERO);
  solids_->BindDepth(0);
  shadow_.Use();
  shadow_.Set("clip_from_view", state.clip_from_view);
  shadow_.Set("tip", tip);
  shadow_.Set("neck", neck);
  shadow_.Set("top", top);
  shadow_.Set("head_radius_mm", bur_radius_mm_);
  shadow_.Set("reach_mm", kShadowReach_mm);
  shadow_.Set("side_mm", kShadowSide_mm);
  glBindVertexArray(empty_array_);
  glDrawArrays(GL_TRIANGLES, 0, 3);
  glDisable(GL_BLEND);
  glDisable(GL_SCISSOR_TEST);
}

void Picture::DrawBurs(const PictureState& state) {
  UseSolid(state);
  int parts = SeenFromAbove(state) ? kHead : kHead | kShank;
  DrawBur(state, *state.scene_from_bur, parts);
  glEnable(GL_BLEND);
  glBlendFuncSeparate(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA, GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
  glDepthMask(GL_FALSE);
  if (parts == kHead) {
    solid_.Set("opacity", 0.15f);
    DrawBur(state, *state.scene_from_bur, kShank);
  }
  if (state.scene_from_ghost) {
    solid_.Set("opacity", 0.42f);
    solid_.Set("ghostly", 0.85f);
    DrawBur(state, *state.scene_from_ghost, parts);
  }
  glDepthMask(GL_TRUE);
  glDisable(GL_BLEND);
}

void Picture::DrawBur(const PictureState& state, const glm::mat4& scene_from_bur, int parts) {
  solid_.Set("view_from_model", state.view_from_scene * scene_from_bur);
  if (parts & kHead) bur_head_.Draw();
  if (parts & kShank) bur_shank_.Draw();
}

// Over everything: the hand feels the force even where the tooth hides the bur.
void Picture::DrawArrow(const PictureState& state) {
  float length = glm::length(state.arrow_mm);
  if (length < 0.05f) return;
  constexpr float kShaft_mm = 0.09f, kTip_mm = 0.24f;
  float tip = std::min(0.7f, 0.5f * length);
  glm::mat4 frame = Along(state.arrow_from_mm, state.arrow_mm);
  UseSolid(state);
  glClear(GL_DEPTH_BUFFER_BIT);
  glm::mat4 view_from_arrow = state.view_from_scene * frame;
  solid_.Set("view_from_model",
             glm::scale(view_from_arrow, glm::vec3(kShaft_mm, kShaft_mm, length - tip)));
  shaft_.Draw();
  solid_.Set("view_from_model",
             glm::scale(glm::translate(view_from_arrow, glm::vec3(0, 0, length - tip)),
                        glm::vec3(kTip_mm, kTip_mm, tip)));
  tip_.Draw();
}

}  // namespace enamel::station::render
