#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/scene/preparation.h"
#include "station/lab/grades/fault_maker.h"
#include "station/lab/grades/outline_by_mesh.h"
#include "station/lab/grades/relief_depth.h"

namespace enamel::station::lab {
namespace {

double Slope(double degrees) { return std::tan(degrees * std::numbers::pi / 180); }

Hollow GrownBy(const scene::Preparation& shape, double side_m, double floor_m) {
  return [shape, by = scene::Growth{side_m, floor_m}](const dvec3& p) {
    return scene::PreparationDistance_m(shape, p, by);
  };
}

// Its floor lower by an amount that may differ from place to place.
template <typename Lower>
Hollow FloorLowered(const scene::Preparation& shape, const Lower& lower_m) {
  return [=](const dvec3& p) {
    return scene::PreparationDistance_m(shape, p + dvec3(0, 0, lower_m(p.x, p.y)));
  };
}

}  // namespace

void FaultMaker::MakeShape() {
  if (task_.shape.parts.at(0).relief.step_um != 0) return MakeFace();
  const double corner = CornerMovesBy() - 1;
  const scene::Preparation open = WithOpenEnds();
  for (const Size s : Sizes({0.05, 0.1, 0.3, 0.5}, 0.3)) {
    for (double way : {1.0, -1.0}) {
      Add(way > 0 ? "walls_over" : "walls_short", s, "mm", "deviation_p95_mm",
          quarter_m_ * kMm + corner * s.value, GrownBy(open, way * s.m(), 0));
      // Not most_left_mm: along the floor's edge a mesh is round, by up to 0.4 voxels
      // (schemas/score.md).
      AddMm(way > 0 ? "floor_over" : "floor_short", {way * s.value, s.must_cost}, "floor_mm",
            GrownBy(open, 0, way * s.m()));
    }
  }
  AddAllSurfaces("floor_mm", "floor_mm", [&](double by_m) { return GrownBy(open, by_m, by_m); });
  MakeLeaningShape();
  const dvec3 bottom = LevelFloor_m();
  AddGouges(bottom - dvec3(0.3e-3, 0.3e-3, 0), bottom + dvec3(0.3e-3, 0.3e-3, 0));
  AddBump(bottom);
}

// A box that ends before an adjacent tooth has no wall there that could be short.
scene::Preparation FaultMaker::WithOpenEnds() {
  constexpr int32_t kOut_um = 600, kSame_um = 60;
  scene::Preparation out = task_.shape;
  if (!NearestNeighbour()) return out;
  const auto middle_um = static_cast<int32_t>(std::lround(landmark_m_.x * 1e6));
  for (scene::PreparationPart& part : out.parts) {
    for (auto& corner : part.corners_um) {
      const int32_t x = part.top_um[0] + corner[0] - middle_um;
      if (std::abs(x) < exercise_.target.half_size_um[0] - kSame_um) continue;
      corner[0] += x > 0 ? kOut_um : -kOut_um;
    }
  }
  return out;
}

// All walls lean about the middle of their height.
void FaultMaker::MakeLeaningShape() {
  const double middle_z = landmark_m_.z - 0.5e-6 * exercise_.target.depth_um;
  auto leaning = [&](double slope) -> Hollow {
    return [=, shape = WithOpenEnds()](const dvec3& p) {
      const scene::Growth by{slope * (p.z - middle_z), 0};
      return scene::PreparationDistance_m(shape, p, by) / std::sqrt(1 + slope * slope);
    };
  };
  // An examiner sees the rim move, not the angle: of a shallow cavity it moves little.
  constexpr double kSeen_mm = 0.13;
  for (Size s : Sizes({5, 10, 20}, 10)) {
    const double rim_mm = 0.5e-3 * exercise_.target.depth_um * Slope(s.value);
    s.must_cost = s.must_cost && rim_mm >= kSeen_mm;
    AddDegrees("taper", s, "wall_tilt_deg", leaning(Slope(s.value)));
    AddDegrees("undercut", s, "undercut_deg", leaning(-Slope(s.value)));
  }
}

// Movement of an upright corner when its walls move by 1: where two parts meet at a right angle, a
// corner of the tooth is left; a polygon has its own.
double FaultMaker::CornerMovesBy() const {
  double most = task_.shape.parts.size() > 1 ? std::sqrt(2.0) : 1;
  for (const scene::PreparationPart& part : task_.shape.parts) {
    if (part.outline != scene::PreparationPart::Outline::kPolygon) continue;
    const auto& c = part.corners_um;
    auto side = [&](size_t i) {
      const auto &a = c[i % c.size()], &b = c[(i + 1) % c.size()];
      const glm::dvec2 d(b[0] - a[0], b[1] - a[1]);
      return d / std::sqrt(glm::dot(d, d));
    };
    for (size_t i = 0; i < c.size(); ++i) {
      // 1 / cos of half the turn.
      most = std::max(most, std::sqrt(2 / (1 + glm::dot(side(i), side(i + 1)))));
    }
  }
  return most;
}

// The middle of the bottom of the first part that is level for 0.7 mm around it: where another part
// is deeper, a pit or a pillar there would have another size.
dvec3 FaultMaker::LevelFloor_m() const {
  constexpr double kAbout_m = 0.7e-3, kUnder_m = 1e-6;
  auto middle = [](const scene::PreparationPart& part) {
    dvec3 out = dvec3(part.top_um[0], part.top_um[1], part.top_um[2] - part.depth_um) * 1e-6;
    const auto ends = [&](size_t axis) {
      const auto [least, most] = std::ranges::minmax(
          part.corners_um, {}, [axis](const auto& corner) { return corner[axis]; });
      return 0.5e-6 * (least[axis] + most[axis]);
    };
    if (!part.corners_um.empty()) out += dvec3(ends(0), ends(1), 0);
    return out;
  };
  for (const scene::PreparationPart& part : task_.shape.parts) {
    const dvec3 at = middle(part);
    bool level = true;
    for (int k = 0; k < 4; ++k) {
      const dvec3 aside(k % 2 == 0 ? kAbout_m : -kAbout_m, k / 2 == 0 ? kAbout_m : -kAbout_m,
                        -kUnder_m);
      const double d = task_.Distance_m(at + aside);
      level = level && d > 0 && d < 2 * kUnder_m;
    }
    if (level) return at;
  }
  return middle(task_.shape.parts.at(0));
}

// A layer off a face: there are no walls to speak of, all of it is floor.
void FaultMaker::MakeFace() {
  const scene::PreparationPart& part = task_.shape.parts[0];
  for (const Size s : Sizes({0.05, 0.1, 0.2, 0.3}, 0.2)) {
    AddMm("floor_over", s, "deepest_over_mm", GrownBy(task_.shape, 0, s.m()));
    AddMm("floor_short", s, "most_left_mm", GrownBy(task_.shape, 0, -s.m()));
  }
  AddAllSurfaces("deepest_over_mm", "most_left_mm",
                 [&](double by_m) { return GrownBy(task_.shape, 0, by_m); });
  MakeUnevenFace();
  MakeFaceMargin();
  auto over = [part](const dvec3& p) { return scene::HeightOverRelief_m(part, p); };
  const dvec3 middle = dvec3(part.top_um[0], part.top_um[1], 0) * 1e-6;
  AddFollowing(middle, over, [over](double by_m) -> Hollow {
    return [=](const dvec3& p) { return by_m - over(p); };
  });
}

// A reduction that is deeper on the root's side than on the edge's, and one that waves. The size is
// the root mean square of the distance between the two floors, by points of the floor inside the
// tooth: d = lower / sqrt(1 + slope^2), weighted with the area relative to that seen from above.
void FaultMaker::MakeUnevenFace() {
  const scene::PreparationPart& part = task_.shape.parts[0];
  const dvec3 middle = dvec3(part.top_um[0], part.top_um[1], 0) * 1e-6;
  const double half_x = part.half_size_um[0] * 1e-6, half_y = part.half_size_um[1] * 1e-6;
  auto rms_mm = [&](const std::function<double(double, double)>& lower_m) {
    constexpr double kStep_m = 0.05e-3;
    double squares = 0, area = 0;
    for (double x = middle.x - half_x; x <= middle.x + half_x; x += kStep_m) {
      for (double y = middle.y - half_y; y <= middle.y + half_y; y += kStep_m) {
        const double at_0 = scene::HeightOverRelief_m(part, {x, y, 0});
        // 1 / sqrt(1 + slope^2)
        const double upright = scene::HeightOverRelief_m(part, {x, y, 1}) - at_0;
        if (volume_.DistanceAt_m({x, y, -at_0 / upright}) >= 0) continue;
        const double d = lower_m(x, y) * upright;
        squares += d * d / upright, area += 1 / upright;
      }
    }
    return area > 0 ? kMm * std::sqrt(squares / area) : 0;
  };
  auto add = [&](const char* name, bool must, const std::function<double(double, double)>& lower) {
    AddMm(name, {rms_mm(lower), must}, "deviation_rms_mm", FloorLowered(task_.shape, lower));
  };
  for (const Size s : Sizes({1, 3, 5}, 3)) {
    add("tilt_floor", s.must_cost,
        [y_m = middle.y, slope = Slope(s.value)](double, double y) { return slope * (y - y_m); });
  }
  for (const Size s : Sizes({0.05, 0.1, 0.2}, 0.1)) {
    add("floor_waviness", s.must_cost,
        [height = std::sqrt(2.0) * s.m(), half_y, y_m = middle.y](double, double y) {
          constexpr double kWaves = 3;
          return height * std::sin(std::numbers::pi * kWaves * (y - y_m) / half_y);
        });
  }
}

// A strip beside the reduction is scraped, so thin that the tooth's own distance says how deep.
void FaultMaker::MakeFaceMargin() {
  constexpr double kDeep_m = 0.08e-3, kHalf_m = 3e-3, kInwards_m = 1e-3;
  double end_x = grid_lo_m_.x;
  for (const OutlinePiece& p : OutlineOn(Surface(), Wanted())) {
    if (std::fabs(p.middle_m.y - landmark_m_.y) < kHalf_m) end_x = std::max(end_x, p.middle_m.x);
  }
  for (const Size s : Sizes({0.2, 0.3, 0.5}, 0.3)) {
    const dvec3 lo(end_x - kInwards_m, landmark_m_.y - kHalf_m, grid_lo_m_.z);
    const dvec3 hi(end_x + s.m(), landmark_m_.y + kHalf_m, grid_hi_m_.z + 1);
    AddMargin(s, Both(Wanted(), [=, tooth = &volume_](const dvec3& p) {
                return std::max(BoxDistance_m(p, lo, hi), -tooth->DistanceAt_m(p) - kDeep_m);
              }));
  }
}

// A pit of 0.8 x 0.8 mm and a pillar of 1.4 x 1.4 mm around a place, their ends exactly as far
// below and above a surface as stated. `over`: height over it; `raised`: the task, higher by this
// amount.
template <typename Over, typename Raised>
void FaultMaker::AddFollowing(const dvec3& at, const Over& over, const Raised& raised) {
  constexpr double kPit_m = 0.4e-3, kPillar_m = 0.7e-3;
  // Deeper than any, by more than a volume's band of four voxels.
  constexpr double kDeepest_m = 1.2e-3;
  auto square = [at](double half_m) {
    return [=](const dvec3& p) {
      return std::max(std::fabs(p.x - at.x), std::fabs(p.y - at.y)) - half_m;
    };
  };
  // `over` is the distance from a plane: where the surface is curved, its own is more.
  const ReliefDepth depth(over, at, kPit_m + 2 * kDeepest_m + 0.5e-3);
  for (const Size s : Sizes({0.1, 0.2, 0.3, 0.57}, 0.3)) {
    AddMm("gouge", s, "deepest_over_mm", Both(Wanted(), [=, in = square(kPit_m)](const dvec3& p) {
            const double aside = in(p);
            if (aside > 0.5e-3) return aside;
            return std::max(aside, depth.Depth_m(p, kDeepest_m) - s.m());
          }));
  }
  for (const Size s : Sizes({0.2, 0.4}, 0.4)) {
    const auto less = raised(s.m());
    AddMm("left", s, "most_left_mm",
          [in = square(kPillar_m), wanted = Wanted(), less](const dvec3& p) {
            return std::max(wanted(p), std::min(less(p), -in(p)));
          });
  }
}

void FaultMaker::MakeCrown() {
  const CrownCut& c = task_.crown;
  for (const Size s : Sizes({0.05, 0.1, 0.3, 0.5}, 0.3)) {
    // Where nothing of the top is left, its walls meet elsewhere.
    if (c.Moved(s.m(), 0).HasTop()) {
      AddMm("walls_over", s, "deviation_p95_mm", Cut(c.Moved(s.m(), 0)));
    }
    AddMm("walls_short", s, "deviation_p95_mm", Cut(c.Moved(-s.m(), 0)));
    AddMm("top_over", s, "deepest_over_mm", Cut(c.Moved(0, s.m())));
    AddMm("top_short", s, "most_left_mm", Cut(c.Moved(0, -s.m())));
  }
  AddAllSurfaces("deviation_p95_mm", "deviation_p95_mm",
                 [&](double by_m) { return Cut(c.Moved(by_m, by_m).Deeper(by_m)); });
  for (const Size s : Sizes({20, 30, 45}, 30)) {
    const CrownCut flat = c.Converging(s.value);
    if (flat.HasTop()) AddDegrees("convergence", s, "convergence_mesiodistal_deg", Cut(flat));
  }
  for (const Size s : Sizes({-3, -5, -10}, -10)) {
    AddDegrees("undercut", s, "convergence_mesiodistal_deg", Cut(c.Undercut(s.value)));
  }
  // Farther in, or its walls would come out of the tooth's side below the top.
  const CrownCut slim = c.Moved(0.6e-3, 0);
  for (const Size s : Sizes({10, 12, 15}, 12)) {
    const CrownCut leaning = slim.Leaning(s.value);
    AddDegrees("lean", {leaning.Lean_deg(), s.must_cost}, "crown_axis_deg", Cut(leaning));
  }
  for (const Size s : Sizes({-0.5, -0.3, -0.1, 0.1, 0.3, 0.5}, 0.3)) {
    AddMm("finish_line", s, "finish_depth_mm", Cut(c.Deeper(s.m())));
  }
  for (const Size s : Sizes({0.05, 0.1, 0.2}, 0.2)) {
    CrownCut wavy = c;
    wavy.wave_m = std::sqrt(2.0) * s.m();
    AddMm("finish_waviness", s, "finish_waviness_mm", Cut(wavy));
  }
  if (c.table) {
    auto raised = [&c](double by_m) {
      CrownCut higher = c;
      higher.table_lower_m -= by_m;
      return Cut(higher);
    };
    return AddFollowing(
        dvec3(c.at_top.middle_x_m, c.at_top.middle_y_m, 0),
        [c](const dvec3& p) { return c.OverTop_m(p); }, raised);
  }
  // In the stump's top, where the tooth reaches above it all around the pit.
  const dvec3 beside(0.3e-3, 0.3e-3, 0);
  for (double y = 0.9; y >= -0.9; y -= 0.1) {
    const dvec3 at(c.at_top.middle_x_m, c.at_top.middle_y_m + y * c.at_top.half_y_m, c.top_z_m);
    auto solid = [&](double x_m, double y_m) {
      const dvec3 p = at + dvec3(x_m, y_m, 0);
      return c.Distance_m(p - dvec3(0, 0, 1e-6)) > -1e-5 && volume_.DistanceAt_m(p) < 0;
    };
    constexpr double k = 0.4e-3;
    if (solid(-k, -k) && solid(k, -k) && solid(-k, k) && solid(k, k)) {
      AddGouges(at - beside, at + beside);
      break;
    }
  }
}

}  // namespace enamel::station::lab
