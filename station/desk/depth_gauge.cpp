#include "station/desk/depth_gauge.h"

#include <imgui.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "common/scene/preparation.h"
#include "common/scene/prepared_target.h"
#include "station/render/panel.h"

namespace enamel::station::desk {
namespace {

constexpr ImU32 kFigure = IM_COL32(255, 255, 255, 255), kBehind = IM_COL32(16, 18, 21, 190),
                kWarning = IM_COL32(0, 0, 0, 255);

// A face is a floor, and a part of the bur can meet one, within 60 degrees of level: the cosine.
constexpr double kFaces = 0.5;
// No cavity is deeper. A wall that leans is come near to in steps of no less.
constexpr double kFar_m = 12e-3, kMinStep_m = 20e-6;
// Apart on the bur's end: with a slope of 45 degrees, points off by half of it err by 0.02 mm in
// the middle of a flat end, and not at its edge.
constexpr double kApart_m = 0.15e-3;
constexpr size_t kMaxPoints = 400;
constexpr int kRing = 24;  // points on an edge

// The point of a bur, in its frame, that is farthest in a direction: of a convex outline, one of its
// pieces' ends, or on an arc whose normals include the direction.
dvec3 FarthestAlong(const cutting::Profile& profile, const dvec3& direction) {
  const double across = std::hypot(direction.x, direction.y);
  double most = -std::numeric_limits<double>::infinity(), r = 0, z = 0;
  const auto take = [&](double at_r, double at_z) {
    const double reach = at_r * across + at_z * direction.z;
    // The first of equal points is nearest to the axis.
    if (reach > most + 1e-12) most = reach, r = at_r, z = at_z;
  };
  for (const cutting::ProfilePiece& p : profile.pieces()) {
    if (!p.arc) {
      take(p.at[0], p.at[1]);
      take(p.to[0], p.to[1]);
      continue;
    }
    take(p.at[0] + p.radius * p.first[0], p.at[1] + p.radius * p.first[1]);
    const bool among = p.first[0] * direction.z - p.first[1] * across >= 0 &&
                       across * p.last[1] - direction.z * p.last[0] >= 0;
    if (among) take(p.at[0] + p.radius * across, p.at[1] + p.radius * direction.z);
    take(p.at[0] + p.radius * p.last[0], p.at[1] + p.radius * p.last[1]);
  }
  if (across == 0) return {r, 0, z};
  return {r * direction.x / across, r * direction.y / across, z};
}

// Points of a bur that can meet a floor first: of its surface, and of its edges, which SampleSurface
// leaves out.
std::vector<cutting::SurfacePoint> EndPoints(const cutting::Bur& bur,
                                             const cutting::Profile& profile) {
  std::vector<cutting::SurfacePoint> out = cutting::SampleSurface(bur, kApart_m, kMaxPoints);
  for (const cutting::ProfilePiece& p : profile.pieces()) {
    if (!p.arc || p.radius > 0 || p.at[0] <= 0) continue;
    for (int i = 0; i < kRing; ++i) {
      const double angle = 2 * std::numbers::pi * i / kRing;
      const dvec3 out_of_axis(std::cos(angle), std::sin(angle), 0);
      out.push_back({p.at[0] * out_of_axis + dvec3(0, 0, p.at[1]),
                     p.first[0] * out_of_axis + dvec3(0, 0, p.first[1]), 0});
    }
  }
  return out;
}

}  // namespace

DepthGauge::DepthGauge(const scene::Scene& scene, const scene::CavityTarget& target,
                       const std::vector<cutting::Bur>& burs, const cutting::Volume& initial)
    : prepared_(target.prepared_tooth), initial_(initial) {
  const auto follows = [](const scene::PreparationPart& part) {
    return part.relief.step_um != 0 || part.outline == scene::PreparationPart::Outline::kStump;
  };
  const bool crown = target.landmark == "crown_top";
  sides_ = crown || std::ranges::any_of(target.parts, follows);
  auto shape = scene::TargetShape(scene, target);
  // A crown without parts has a known height only; its stump is unknown.
  const bool unknown = !target.prepared.IsZero() || (crown && target.parts.empty());
  if (shape.ok() && target.depth_um > 0 && !unknown) {
    if (!sides_) from_z_m_ = scene.landmarks.at(target.landmark)[2] * 1e-6;
    errs_ = scene::DistanceErrs(*shape);
    shape_ = std::move(*shape);
  }
  for (const cutting::Bur& bur : burs) {
    End& end = ends_.emplace_back(End{cutting::ProfileOf(bur), {}});
    if (!from_z_m_ && (shape_ || prepared_)) end.points = EndPoints(bur, end.profile);
  }
}

double DepthGauge::Along_m(dvec3 at_m, const dvec3& direction) const {
  const double least_m = 0.25 * initial_.spec().voxel_m();
  double way_m = 0, inside_m = -initial_.DistanceAt_m(at_m);
  while (inside_m > 0) {
    // No surface is nearer than the distance says, and that is known to four voxels.
    const double step_m = std::max(inside_m, least_m);
    at_m += step_m * direction;
    const double next_m = -initial_.DistanceAt_m(at_m);
    // Between the two the distance is taken as linear.
    if (next_m <= 0) return way_m + step_m * inside_m / (inside_m - next_m);
    way_m += step_m;
    inside_m = next_m;
  }
  return way_m;
}

double DepthGauge::UnderSurface_m(const dvec3& point_m) const {
  if (!sides_) return Along_m(point_m, dvec3(0, 0, 1));
  double least_m = std::numeric_limits<double>::infinity();
  for (int z = 0; z <= 1; ++z) {
    for (int y = -1; y <= 1; ++y) {
      for (int x = -1; x <= 1; ++x) {
        if (x == 0 && y == 0 && z == 0) continue;
        least_m = std::min(least_m, Along_m(point_m, glm::normalize(dvec3(x, y, z))));
      }
    }
  }
  return least_m;
}

double DepthGauge::BeyondTarget_m(const dvec3& point_m) const {
  return prepared_ ? -prepared_->volume.DistanceAt_m(point_m)
                   : scene::PreparationDistance_m(*shape_, point_m);
}

// The target's end at this point is a floor, not a wall.
bool DepthGauge::FacesUp(const dvec3& point_m) const {
  const double apart_m = prepared_ ? 0.5 * initial_.spec().voxel_m() : 1e-6;
  dvec3 slope(0);
  for (int i = 0; i < 3; ++i) {
    dvec3 step(0);
    step[i] = apart_m;
    slope[i] = BeyondTarget_m(point_m - step) - BeyondTarget_m(point_m + step);
  }
  return slope.z > kFaces * glm::length(slope);
}

// To the floor, straight down; negative where that is above the point.
std::optional<double> DepthGauge::Fall_m(const dvec3& point_m) const {
  const auto beyond = [&](double down_m) { return BeyondTarget_m(point_m - dvec3(0, 0, down_m)); };
  // A shape has no upper end: a point that is outside of it up there is beside it.
  if (shape_ && beyond(-kFar_m) > 0) return std::nullopt;
  double here_m = 0, beyond_m = beyond(0);
  const bool above = beyond_m <= 0;
  double before_m = here_m;
  while ((beyond_m <= 0) == above) {
    before_m = here_m;
    here_m += (above ? 1 : -1) * std::max(std::abs(beyond_m) / errs_, kMinStep_m);
    if (std::abs(here_m) > kFar_m) return std::nullopt;
    beyond_m = beyond(here_m);
  }
  // 12 mm at most, to 0.01 um.
  for (int i = 0; i < 20; ++i) {
    const double middle_m = 0.5 * (before_m + here_m);
    ((beyond(middle_m) <= 0) == above ? before_m : here_m) = middle_m;
  }
  const double fall_m = 0.5 * (before_m + here_m);
  const dvec3 met_m = point_m - dvec3(0, 0, fall_m);
  // Beside a prepared tooth's hollow the way ends at the uncut surface.
  const bool uncut = prepared_ && initial_.DistanceAt_m(met_m) > -0.5 * initial_.spec().voxel_m();
  return uncut || !FacesUp(met_m) ? std::nullopt : std::optional(fall_m);
}

std::optional<double> DepthGauge::ToFloor_m(const cutting::Pose& pose, const End& end,
                                            const dvec3& deepest_m) const {
  if (!shape_ && !prepared_) return std::nullopt;
  // The edge of a bur that leans on a wall may be in it: the axis says which floor is below.
  if (from_z_m_) return Fall_m({pose.tip_m.x, pose.tip_m.y, deepest_m.z});
  std::optional<double> least_m = Fall_m(deepest_m);
  const dmat3 scene_from_bur = pose.orientation.Matrix();
  for (const cutting::SurfacePoint& point : end.points) {
    // The flank meets walls.
    if ((scene_from_bur * point.normal).z > -kFaces) continue;
    const auto fall_m = Fall_m(pose.tip_m + scene_from_bur * point.position_m);
    if (fall_m && (!least_m || *fall_m < *least_m)) least_m = fall_m;
  }
  return least_m;
}

BurDepth DepthGauge::At(const cutting::Pose& pose, size_t bur) const {
  const End& end = ends_[bur];
  const dmat3 scene_from_bur = pose.orientation.Matrix();
  // From the left: by the transpose, which turns back.
  const dvec3 down = dvec3(0, 0, -1) * scene_from_bur;
  const dvec3 deepest_m = pose.tip_m + scene_from_bur * FarthestAlong(end.profile, down);
  if (initial_.DistanceAt_m(deepest_m) >= 0) return {};
  BurDepth out;
  out.deep_m = from_z_m_ ? *from_z_m_ - deepest_m.z : UnderSurface_m(deepest_m);
  if (*out.deep_m < 0) out.deep_m.reset();
  out.to_floor_m = ToFloor_m(pose, end, deepest_m);
  return out;
}

double DepthGauge::Rounded_mm(double metres) const {
  const double step_mm = initial_.spec().voxel_m() * 1e3;
  return step_mm * std::round(metres * 1e3 / step_mm);
}

std::string DepthGauge::Text(const language::Words& words, const BurDepth& depth) const {
  const auto figure = [&](double mm) {
    return words.Decimal(mm, initial_.spec().voxel_m() < 0.1e-3 ? 2 : 1);
  };
  std::string out;
  if (depth.deep_m) out = words.Say("depth.text", {{"depth", figure(Rounded_mm(*depth.deep_m))}});
  if (!depth.to_floor_m) return out;
  const double left_mm = Rounded_mm(*depth.to_floor_m);
  if (!out.empty()) out += "\n";
  return out + words.Say(left_mm > 0   ? "depth.to_floor"
                         : left_mm < 0 ? "depth.below_floor"
                                       : "depth.at_floor",
                         {{"distance", figure(std::abs(left_mm))}});
}

void WriteBeside(const dvec3& point_m, const std::string& figure, const std::string& warning,
                 const render::Camera& camera, const render::Fonts& fonts, int width, int height) {
  const auto w = static_cast<float>(width), h = static_cast<float>(height);
  const glm::vec4 clip =
      camera.ClipFromView(w / h) * camera.ViewFromScene() * glm::vec4(glm::vec3(point_m * 1e3), 1);
  if (clip.w <= 0 || std::abs(clip.x) > clip.w || std::abs(clip.y) > clip.w) return;
  const ImFont* font = fonts.text;
  const float aside = 36 * fonts.scale, edge = 6 * fonts.scale;
  // Right of the bur and below its tip: the bur itself is above it.
  ImVec2 at{0.5f * w * (1 + clip.x / clip.w) + aside, 0.5f * h * (1 - clip.y / clip.w) + edge};
  // In words on yellow: no two colours need to differ, and nothing flashes.
  const auto [r, g, b] = render::ColourOf(render::Bearing::kCareful);
  const struct {
    const std::string& text;
    ImU32 colour, behind;
  } lines[] = {{figure, kFigure, kBehind},
               {warning, kWarning, ImGui::ColorConvertFloat4ToU32({r, g, b, 1})}};
  ImDrawList* list = ImGui::GetBackgroundDrawList();
  for (const auto& line : lines) {
    if (line.text.empty()) continue;
    const ImVec2 size = font->CalcTextSizeA(font->FontSize, w, 0, line.text.c_str());
    at.x = std::min(at.x, w - size.x - 2 * edge);
    at.y = std::min(at.y, h - size.y - 2 * edge);
    list->AddRectFilled({at.x - edge, at.y - edge}, {at.x + size.x + edge, at.y + size.y + edge},
                        line.behind, edge);
    list->AddText(font, font->FontSize, at, line.colour, line.text.c_str());
    at.y += size.y + 3 * edge;
  }
}

}  // namespace enamel::station::desk
