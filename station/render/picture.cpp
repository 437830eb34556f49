#include "station/render/picture.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>

#include "station/render/handpiece.h"
#include "station/render/materials.h"
#include "station/render/mouth_mirror.h"
#include "station/render/revolve.h"
#include "station/render/shaders.h"

namespace enamel::station::render {
namespace {

TriangleBuffer& Fill(TriangleBuffer& buffer, const Shape& shape) {
  buffer.Upload(shape.vertices, shape.indices);
  return buffer;
}

// As in the shaders: over the left shoulder, in view.
const glm::vec3 kKeyLight = glm::normalize(glm::vec3(-0.55f, 0.75f, 0.55f));
// Length of a shadow, and its reach beside the bur.
constexpr float kShadowReach_mm = 5, kShadowSide_mm = 1.2f, kShankShadow_mm = 6;

// Radius of a line on the tooth: three pixels where a crown fills a window.
constexpr float kLineRadius_mm = 0.05f;

// Parts of a bur.
constexpr int kHead = 1, kShank = 2;

// Looking down the shank, which would then hide the cut.
bool SeenFromAbove(const PictureState& state, const Eye& eye) {
  glm::vec4 axis = eye.view_from_scene * (*state.scene_from_bur)[2];
  return axis.z > 0.85f;
}

// What is drawn in between is seen through by its opacity, and hides nothing drawn later.
void BeginGlass() {
  glEnable(GL_BLEND);
  glBlendFuncSeparate(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA, GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
  glDepthMask(GL_FALSE);
}
void EndGlass() {
  glDepthMask(GL_TRUE);
  glDisable(GL_BLEND);
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

Picture::Picture(std::span<const cutting::Bur> burs, size_t group_count)
    : solid_({kLooks, kSolidVertex}, {kLit, kSolidFragment}),
      shadow_({kFullScreenVertex}, {kShadowFragment}),
      mirror_({kLooks, kSolidVertex}, {kMirrorFragment}),
      groups_(group_count),
      still_sight_(programs_),
      turning_sight_(programs_) {
  for (const cutting::Bur& bur : burs) {
    BurBody& body = burs_.emplace_back();
    Fill(body.head, BurHeadShape(bur));
    Fill(body.shank, BurShankShape(bur));
    body.height_mm = static_cast<float>(bur.height_m() * 1000);
    Fill(body.handpiece, HandpieceShape(body.height_mm));
    body.radius_mm = static_cast<float>(bur.radius_m * 1000);
  }
  Fill(shaft_, ShaftShape());
  Fill(tip_, TipShape());
  Fill(glass_, GlassShape());
  Fill(setting_, SettingShape());
  solid_.Use();
  SetMaterials(solid_);
  solid_.Set("ghost_colour", GhostColour());
  shadow_.Use();
  shadow_.Set("depth", 0);
  shadow_.Set("to_light", kKeyLight);
  mirror_.Use();
  mirror_.Set("reflection", 0);
  mirror_.Set("radius_mm", kMirrorRadius_mm);
}

void Picture::Changed(const Bounds& bounds) {
  still_sight_.tooth.Changed(bounds);
  turning_sight_.tooth.Changed(bounds);
  if (reflected_) reflected_->tooth.Changed(bounds);
}

void Picture::Replace(const GroupMesh& mesh) {
  auto& group = groups_[mesh.group];
  if (group && !mesh.same_surface) Changed(group->bounds);
  if (!group) group = std::make_unique<Body>();
  work_.triangles -= group->triangles.triangle_count();
  group->triangles.Upload(mesh.vertices, mesh.indices, mesh.coarse);
  work_.triangles += group->triangles.triangle_count();
  group->bounds = mesh.bounds;
  if (!mesh.same_surface) Changed(group->bounds);
}

void Picture::SetScenery(const Scenery& scenery) {
  auto keep = [this](const std::vector<GroupMesh>& meshes, std::vector<std::unique_ptr<Body>>& to) {
    for (const auto& old : to) Changed(old->bounds);
    to.clear();
    for (const GroupMesh& mesh : meshes) {
      to.push_back(std::make_unique<Body>());
      to.back()->triangles.Upload(mesh.vertices, mesh.indices, mesh.coarse);
      to.back()->bounds = mesh.bounds;
      Changed(mesh.bounds);
    }
  };
  keep(scenery.fixed, fixed_);
  keep(scenery.giving_way, giving_way_);
  keep(scenery.opposite, opposite_);
  giving_way_boxes_ = BoxesOf(scenery.giving_way);
  opposite_boxes_ = BoxesOf(scenery.opposite);
  work_mm_ = scenery.work_mm;
  hides_below_ = scenery.hides_below;
}

void Picture::ChooseBodies(const PictureState& state) {
  bodies_.clear();
  for (const auto& group : groups_) {
    const bool hidden =
        group && state.scenery &&
        glm::dot(hides_below_, glm::vec4(group->bounds.middle_mm, 1)) < -group->bounds.radius_mm;
    if (group && !hidden) bodies_.push_back(group.get());
  }
  if (!state.scenery) return;
  for (const auto& body : fixed_) bodies_.push_back(body.get());
  const glm::vec3 eye(glm::inverse(state.view_from_scene)[3]);
  auto covers = [&](const Box& box) {
    return std::ranges::any_of(work_mm_, [&](const glm::vec3& p) { return Covers(box, p, eye); });
  };
  for (size_t i = 0; i < giving_way_.size(); ++i) {
    if (!covers(giving_way_boxes_[i])) bodies_.push_back(giving_way_[i].get());
  }
  if (std::ranges::any_of(opposite_boxes_, covers)) return;
  for (const auto& body : opposite_) bodies_.push_back(body.get());
}

Quality Picture::QualityNow(const PictureState& state, const Quality& wanted) {
  bool moved = last_view_ && *last_view_ != state.view_from_scene;
  last_view_ = state.view_from_scene;
  still_ = moved ? 0 : std::min(still_ + 1, kStillPictures);
  return wanted.lighter_turning && still_ < kStillPictures ? WhileTurning(wanted) : wanted;
}

void Picture::Sight::Resize(int width, int height) {
  if (!tooth.Resize(width, height)) return;
  frame = std::make_unique<Target>(width, height, std::initializer_list<GLenum>{GL_RGBA8}, true,
                                   GL_LINEAR);
}

void Picture::Draw(const PictureState& state, int width, int height, const Quality& wanted) {
  const Quality quality = QualityNow(state, wanted);
  auto scaled = [&](int n) {
    return std::max(1, static_cast<int>(std::lround(static_cast<float>(n) * quality.scale)));
  };
  const bool turning = !(quality == wanted);
  Sight& sight = turning ? turning_sight_ : still_sight_;
  // The other's eye was elsewhere.
  (turning ? still_sight_ : turning_sight_).tooth.Forget();
  sight.Resize(scaled(width), scaled(height));
  if (!result_ || result_->width() != width || result_->height() != height) {
    result_ = std::make_unique<Target>(width, height, std::initializer_list<GLenum>{GL_RGBA8},
                                       false, GL_NEAREST);
  }
  ChooseBodies(state);
  ShapeOf(state.chips, chip_shape_);
  Fill(chips_, chip_shape_);
  const Eye eye{state.view_from_scene, state.clip_from_view, false, {0, 0, 0, 1}};
  DrawSight(sight, state, eye, quality,
            PixelRect::Whole(sight.tooth.width(), sight.tooth.height()));
  work_.triangles_drawn = sight.tooth.work().triangles_drawn;
  work_.whole = sight.tooth.work().whole;
  work_.coarse = quality.coarse;
  DrawMirror(sight, state, eye, quality);
  DrawHandpiece(state, eye);
  DrawArrow(state, eye);
  sight.frame->CopyColourTo(*result_);
}

void Picture::DrawSight(Sight& sight, const PictureState& state, const Eye& eye,
                        const Quality& quality, const PixelRect& part) {
  sight.tooth.Draw(bodies_, eye, quality, part);
  Scissor(part);
  sight.tooth.composed().CopyColourTo(*sight.frame);
  sight.tooth.solids().CopyDepthTo(*sight.frame);
  sight.frame->Bind();
  if (state.lines && lines_.triangle_count() > 0) {
    UseSolid(state, eye);
    lines_.Draw();
  }
  if (state.scene_from_bur) {
    DrawShadow(sight, state, eye, part);
    Scissor(part);
    UseSolid(state, eye);
    chips_.Draw();
    DrawBurs(state, eye);
  }
  glDisable(GL_SCISSOR_TEST);
  SeeWith({});
}

// The glass is where its reflection is drawn: the same pixels, from the mirrored eye.
void Picture::DrawMirror(const Sight& sight, const PictureState& state, const Eye& eye,
                         const Quality& quality) {
  if (!state.scene_from_mirror) {
    reflected_.reset();
    return;
  }
  const glm::mat4& mirror = *state.scene_from_mirror;
  const glm::mat4 view_from_mirror = eye.view_from_scene * mirror;
  const PixelRect part = AroundBall(eye.view_from_scene, eye.clip_from_view, sight.frame->width(),
                                    sight.frame->height(), glm::vec3(mirror[3]), kMirrorRadius_mm);
  // The viewer is at the view's origin; behind the glass it is not seen.
  const bool faces = glm::dot(glm::vec3(view_from_mirror[2]), glm::vec3(view_from_mirror[3])) < 0;
  if (faces && !part.empty()) {
    if (!reflected_) reflected_ = std::make_unique<Sight>(programs_);
    reflected_->Resize(sight.frame->width(), sight.frame->height());
    Eye mirrored = eye;
    mirrored.view_from_scene = eye.view_from_scene * Reflection(mirror);
    mirrored.mirrored = true;
    const glm::vec3 out(mirror[2]);
    mirrored.before = glm::transpose(glm::inverse(mirrored.view_from_scene)) *
                      glm::vec4(out, -glm::dot(out, glm::vec3(mirror[3])));
    DrawSight(*reflected_, state, mirrored, quality, part);
    Scissor(part);
    DrawHandpiece(state, mirrored);
    glDisable(GL_SCISSOR_TEST);
    SeeWith({});
    sight.frame->Bind();
    UseSolid(state, eye);
    mirror_.Use();
    mirror_.Set("clip_from_view", eye.clip_from_view);
    mirror_.Set("view_from_model", view_from_mirror);
    reflected_->frame->BindColour(0, 0);
    glass_.Draw();
  } else {
    reflected_.reset();
  }
  UseSolid(state, eye);
  solid_.Set("view_from_model", view_from_mirror);
  setting_.Draw();
}

void Picture::UseSolid(const PictureState& state, const Eye& eye) {
  glDisable(GL_BLEND);
  glEnable(GL_DEPTH_TEST);
  SeeWith(eye);
  solid_.Use();
  solid_.Set("clip_from_view", eye.clip_from_view);
  solid_.Set("view_from_model", eye.view_from_scene);
  solid_.Set("before", eye.before);
  solid_.Set("up_in_view", eye.up_in_view());
  solid_.Set("spin", state.bur_spin);
  solid_.Set("flute_height_mm", burs_[state.bur].height_mm);
  solid_.Set("opacity", 1.0f);
  solid_.Set("ghostly", 0.0f);
}

void Picture::SetLines(std::span<const surface::LineSegment> lines) {
  Fill(lines_, LineShape(lines, kLineRadius_mm));
}

// The bur as two capsules, cutting part and shank, seen from the light and from beside the tooth.
void Picture::DrawShadow(const Sight& sight, const PictureState& state, const Eye& eye,
                         const PixelRect& seen) {
  glm::mat4 view_from_bur = eye.view_from_scene * *state.scene_from_bur;
  auto at = [&](float z) { return glm::vec3(view_from_bur * glm::vec4(0, 0, z, 1)); };
  const float height_mm = burs_[state.bur].height_mm, radius_mm = burs_[state.bur].radius_mm;
  float lift = std::min(radius_mm, 0.5f * height_mm);
  glm::vec3 tip = at(lift), neck = at(height_mm), top = at(height_mm + kShankShadow_mm);
  int w = sight.frame->width(), h = sight.frame->height();
  PixelRect part;
  for (const glm::vec3& p : {tip, neck, top}) {
    for (float along : {0.0f, kShadowReach_mm}) {
      part = part.Around(AroundBall(glm::mat4(1), eye.clip_from_view, w, h, p - along * kKeyLight,
                                    radius_mm + kShadowSide_mm));
    }
  }
  part = part.Within(seen);
  if (part.empty()) return;
  Scissor(part);
  glDisable(GL_DEPTH_TEST);
  glEnable(GL_BLEND);
  glBlendFunc(GL_DST_COLOR, GL_ZERO);
  sight.tooth.solids().BindDepth(0);
  shadow_.Use();
  shadow_.Set("clip_from_view", eye.clip_from_view);
  shadow_.Set("tip", tip);
  shadow_.Set("neck", neck);
  shadow_.Set("top", top);
  shadow_.Set("head_radius_mm", radius_mm);
  shadow_.Set("reach_mm", kShadowReach_mm);
  shadow_.Set("side_mm", kShadowSide_mm);
  glBindVertexArray(programs_.empty_array);
  glDrawArrays(GL_TRIANGLES, 0, 3);
  glDisable(GL_BLEND);
}

void Picture::DrawBurs(const PictureState& state, const Eye& eye) {
  UseSolid(state, eye);
  const BurBody& bur = burs_[state.bur];
  int parts = SeenFromAbove(state, eye) ? kHead : kHead | kShank;
  DrawBur(bur, eye, *state.scene_from_bur, parts);
  BeginGlass();
  if (parts == kHead) {
    solid_.Set("opacity", kGlass);
    DrawBur(bur, eye, *state.scene_from_bur, kShank);
  }
  if (state.scene_from_ghost) {
    solid_.Set("opacity", 0.42f);
    solid_.Set("ghostly", 0.85f);
    DrawBur(bur, eye, *state.scene_from_ghost, parts);
  }
  EndGlass();
}

void Picture::DrawHandpiece(const PictureState& state, const Eye& eye) {
  if (!state.scene_from_bur || !state.handle_azimuth) return;
  UseSolid(state, eye);
  const BurBody& body = burs_[state.bur];
  const glm::mat4 view_from_handpiece =
      eye.view_from_scene *
      glm::rotate(*state.scene_from_bur, *state.handle_azimuth, glm::vec3(0, 0, 1));
  const float opacity =
      HandpieceOpacity(body.height_mm, glm::vec3(glm::inverse(view_from_handpiece)[3]));
  solid_.Set("view_from_model", view_from_handpiece);
  if (opacity < 1) {
    solid_.Set("opacity", opacity);
    BeginGlass();
    // Its near side alone: glass of one thickness.
    glEnable(GL_CULL_FACE);
    glCullFace(eye.mirrored ? GL_FRONT : GL_BACK);
  }
  body.handpiece.Draw();
  if (opacity < 1) {
    glDisable(GL_CULL_FACE);
    EndGlass();
    solid_.Set("opacity", 1.0f);
  }
}

void Picture::DrawBur(const BurBody& bur, const Eye& eye, const glm::mat4& scene_from_bur,
                      int parts) {
  solid_.Set("view_from_model", eye.view_from_scene * scene_from_bur);
  if (parts & kHead) bur.head.Draw();
  if (parts & kShank) bur.shank.Draw();
}

// Over everything: the hand feels the force even where the tooth hides the bur.
void Picture::DrawArrow(const PictureState& state, const Eye& eye) {
  float length = glm::length(state.arrow_mm);
  if (length < 0.05f) return;
  constexpr float kShaft_mm = 0.09f, kTip_mm = 0.24f;
  float tip = std::min(0.7f, 0.5f * length);
  glm::mat4 frame = Along(state.arrow_from_mm, state.arrow_mm);
  UseSolid(state, eye);
  glClear(GL_DEPTH_BUFFER_BIT);
  glm::mat4 view_from_arrow = eye.view_from_scene * frame;
  solid_.Set("view_from_model",
             glm::scale(view_from_arrow, glm::vec3(kShaft_mm, kShaft_mm, length - tip)));
  shaft_.Draw();
  solid_.Set("view_from_model",
             glm::scale(glm::translate(view_from_arrow, glm::vec3(0, 0, length - tip)),
                        glm::vec3(kTip_mm, kTip_mm, tip)));
  tip_.Draw();
}

}  // namespace enamel::station::render
