#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/scoring/task.h"
#include "station/lab/grades/fault_maker.h"

namespace enamel::station::lab {
namespace {

using cutting::Tissue;

constexpr std::array<const char*, 4> kWalls = {"mesial", "distal", "buccal", "lingual"};
constexpr double kLeft_m = 0.3e-3;              // of tooth behind a wall, at the least
constexpr size_t kAnyWall = 1, kFloorFace = 4;  // every box has a distal wall

double Slope(double degrees) { return std::tan(degrees * std::numbers::pi / 180); }

}  // namespace

Hollow FaultMaker::BoxWith(size_t face, const Face& as) const {
  BoxCavity box = task_.box;
  box.faces[face] = as;
  return [box](const dvec3& p) { return box.Distance_m(p); };
}

void FaultMaker::MakeBox() {
  for (size_t w = 0; w < kWalls.size(); ++w) {
    if (!HasWall(w)) continue;
    const std::string name = kWalls[w];
    for (const Size s : WallSizes(w)) {
      AddMm("wall_" + name, s, "wall_" + name + "_mm", BoxWith(w, {.moved_m = s.m()}));
    }
    for (const Size s : LeanSizes({1, 5, 10, 20})) {
      AddDegrees("tilt_" + name, s, "tilt_" + name + "_deg", BoxWith(w, {.slope = Slope(s.value)}));
    }
  }
  MakeLeaningWalls(kAnyWall);
  MoveBox();
  // The longest wall has the waves: three of them on a short one are steeper than voxels can show.
  const BoxCavity& b = task_.box;
  const size_t long_wall = b.half_x_m > b.half_y_m ? 2 : kAnyWall;
  // The height of a wave whose root mean square is the size. Where caries is followed, walls have
  // any position.
  for (const Size s : Sizes({0.02, 0.05, 0.1, 0.2}, 0.2)) {
    if (HasCaries()) break;
    const Face wave{.wave_m = std::sqrt(2.0) * s.m()};
    AddMm("waviness", s, "wall_waviness_mm", BoxWith(long_wall, wave));
    AddMm("floor_waviness", s, "floor_waviness_mm", BoxWith(kFloorFace, wave));
  }
  for (const Size s : Sizes({-0.5, -0.3, -0.1, -0.05, 0.05, 0.1, 0.3, 0.5, 1}, 0.3)) {
    AddMm("floor", s, "floor_mm", BoxWith(kFloorFace, {.moved_m = s.m()}));
  }
  for (const Size s : Sizes({1, 5, 15}, 15)) {
    if (HasCaries()) break;  // its floor is where the lesion ends
    AddDegrees("tilt_floor", s, "tilt_floor_deg", BoxWith(kFloorFace, {.slope = Slope(s.value)}));
  }
  AddAllSurfaces("floor_mm", "floor_mm", [&](double by_m) -> Hollow {
    BoxCavity box = task_.box;
    for (size_t f = 0; f < box.faces.size(); ++f) {
      if (f == kFloorFace || HasWall(f)) box.faces[f].moved_m = by_m;
    }
    return [box](const dvec3& p) { return box.Distance_m(p); };
  });
  AddPillars();
  // A pit of 0.6 x 0.6 mm in the floor's corner, away from an open side.
  constexpr double kPit_m = 0.6e-3;
  dvec3 corner = b.centre_m + dvec3(-b.half_x_m, -b.half_y_m, -b.depth_m);
  if (task_.open_mesial && b.mesial_x < 0) corner.x = b.centre_m.x + b.half_x_m - kPit_m;
  AddGouges(corner, corner + dvec3(kPit_m, kPit_m, 0));
  MakeMargins();
}

// A square pillar is left in the middle, up to the tooth's surface.
void FaultMaker::AddPillars() {
  constexpr double kFarFromCut_m = scoring::TaskVolumes::kStanding_m;
  const BoxCavity& b = task_.box;
  for (const Size s : Sizes({0.4, 0.6, 0.8}, 0.4)) {
    const dvec3 half(s.m() / 2, s.m() / 2, 0);
    const double foot = b.centre_m.z - b.depth_m;
    const dvec3 lo(b.centre_m.x - half.x, b.centre_m.y - half.y, foot - 1);
    const dvec3 hi(b.centre_m.x + half.x, b.centre_m.y + half.y, grid_hi_m_.z + 1);
    const double left_m3 =
        VolumeWhere_m3(volume_, grid_lo_m_, grid_hi_m_, [&](const dvec3& p, Tissue) {
          return BoxDistance_m(p, lo, hi) < 0 && p.z > foot + kFarFromCut_m &&
                 task_.Distance_m(p) < 0;
        });
    const Hollow wanted = Wanted();
    const double sides_m2 = 4 * left_m3 / s.m();
    Add("pillar", {left_m3 * kMm3, s.must_cost}, "mm3", "left_standing_mm3",
        (sides_m2 + half.x * half.x * 4) * quarter_m_ * kMm3,
        [=](const dvec3& p) { return std::max(wanted(p), -BoxDistance_m(p, lo, hi)); });
  }
}

// A wall moved out of the tooth's side is none: moves only so far that some tooth is left behind
// it.
std::vector<FaultMaker::Size> FaultMaker::WallSizes(size_t wall) const {
  std::vector<Size> out = Sizes({-1, -0.5, -0.3, -0.1, -0.05, 0.05, 0.1, 0.3, 0.5, 1}, 0.3);
  const double most_mm = std::floor(10 * kMm * (RoomBehind_m(wall) - kLeft_m)) / 10;
  if (out.back().value <= most_mm) return out;
  const Size cut = out.back();
  out.pop_back();
  if (out.empty() || most_mm > out.back().value) out.push_back({most_mm, cut.must_cost});
  return out;
}

// How far the tooth extends beyond a wall, at the least in the middle of its length and height.
double FaultMaker::RoomBehind_m(size_t wall) const {
  constexpr double kFarthest_m = 2e-3;
  const BoxCavity& b = task_.box;
  const bool along_y = wall < 2;
  const double sign = (wall % 2 == 0 ? 1 : -1) * (along_y ? b.mesial_x : 1);
  const double step = volume_.spec().voxel_m() / 2;
  double least = kFarthest_m;
  for (double along : {-0.5, 0.0, 0.5}) {
    dvec3 at = b.centre_m;
    (along_y ? at.x : at.y) += sign * (along_y ? b.half_x_m : b.half_y_m);
    (along_y ? at.y : at.x) += along * (along_y ? b.half_y_m : b.half_x_m);
    const double floor = b.centre_m.z - b.depth_m, top = TopNear(at);
    for (double up : {0.25, 0.5, 0.75}) {
      at.z = floor + up * (top - floor);
      for (double out = 0; out < least; out += step) {
        dvec3 p = at;
        (along_y ? p.x : p.y) += sign * out;
        if (volume_.DistanceAt_m(p) >= 0 || volume_.TissueAtPoint(p) == Tissue::kNeighbour) {
          least = out;
        }
      }
    }
  }
  return least;
}

// Ends of a low wall that leans move by less than costs a point.
std::vector<FaultMaker::Size> FaultMaker::LeanSizes(std::initializer_list<double> all) const {
  constexpr double kThreshold_deg = 10, kEndsMove_m = 0.15e-3;
  std::vector<Size> out = Sizes(all, kThreshold_deg);
  for (Size& s : out) {
    s.must_cost = s.must_cost && 0.5 * task_.box.depth_m * Slope(s.value) >= kEndsMove_m;
  }
  return out;
}

void FaultMaker::MakeLeaningWalls(size_t wall) {
  for (const Size s : LeanSizes({5, 10, 20})) {
    AddDegrees("undercut", s, "undercut_deg", BoxWith(wall, {.slope = -Slope(s.value)}));
    BoxCavity box = task_.box;
    for (size_t w = 0; w < kWalls.size(); ++w) {
      if (HasWall(w)) box.faces[w].slope = Slope(s.value);
    }
    AddDegrees("taper", s, "wall_tilt_deg", [box](const dvec3& p) { return box.Distance_m(p); });
  }
}

// The whole cut is elsewhere: towards the buccal wall, away from the mesial one, or turned.
void FaultMaker::MoveBox() {
  for (const Size s : Sizes({0.1, 0.2, 0.3, 0.5}, 0.3)) {
    for (const size_t wall : {size_t{2}, size_t{1}}) {
      const size_t opposite = wall == 2 ? 3 : 0;
      if (!HasWall(opposite) || RoomBehind_m(wall) < s.m() + kLeft_m) continue;
      BoxCavity box = task_.box;
      box.faces[wall].moved_m = s.m();
      box.faces[opposite].moved_m = -s.m();
      AddMm(std::string("shift_") + kWalls[wall], s, std::string("wall_") + kWalls[wall] + "_mm",
            [box](const dvec3& p) { return box.Distance_m(p); });
    }
  }
  const dvec3 about = task_.box.centre_m;
  const double all = TakenAbove(grid_lo_m_.z);
  for (const Size s : Sizes({5, 10, 15}, 10)) {
    if (!HasWall(0) || !(all > 0)) break;
    const Hollow centred = [box = task_.box, about](const dvec3& p) {
      return box.Distance_m(p + about);
    };
    const Hollow taken = [turned = Turned(centred, s.value), about](const dvec3& p) {
      return turned(p - about);
    };
    double both = 0;
    VolumeWhere_m3(
        volume_, grid_lo_m_, grid_hi_m_,
        [&](const dvec3& p, Tissue t) {
          both += t != Tissue::kNeighbour && task_.Distance_m(p) < 0 &&
                          volume_.DistanceAt_m(p) < 0 && taken(p) < 0
                      ? 1
                      : 0;
          return false;
        },
        Wanted());
    Add("turn", {100 * both / all, s.must_cost}, "%", "task_done_percent", kShareTolerance_percent,
        taken);
  }
}

// The rim of the distal wall is farther out, down to 0.6 mm and at most 0.4 of the wall: beyond
// that, the wall itself would be off.
void FaultMaker::MakeMargins() {
  constexpr double kRim_m = 0.6e-3, kOfWall = 0.4;
  const BoxCavity& b = task_.box;
  const double top = TopNear(b.centre_m - dvec3(b.mesial_x * b.half_x_m, 0, 0));
  const double rim = std::min(kRim_m, kOfWall * (top - b.centre_m.z + b.depth_m));
  for (const Size s : Sizes({0.2, 0.3, 0.5}, 0.3)) {
    const double rim_x = b.centre_m.x - b.mesial_x * (b.half_x_m + s.m());
    const dvec3 lo(std::min(rim_x, b.centre_m.x), b.centre_m.y - b.half_y_m, top - rim);
    const dvec3 hi(std::max(rim_x, b.centre_m.x), b.centre_m.y + b.half_y_m, grid_hi_m_.z + 1);
    AddMargin(s, Both(Wanted(), [=](const dvec3& p) { return BoxDistance_m(p, lo, hi); }));
  }
}

// Caries under the task's floor's last part is left.
void FaultMaker::AddCaries() {
  if (!HasCaries() || task_.kind != Task::Kind::kBox) return;
  for (const Size s : Sizes({0.2, 0.4, 0.6}, 0.4)) {
    const Hollow taken = BoxWith(kFloorFace, {.moved_m = -s.m()});
    const double left_m3 = VolumeWhere_m3(
        volume_, grid_lo_m_, grid_hi_m_,
        [&](const dvec3& p, Tissue t) {
          return t == Tissue::kCaries && task_.Distance_m(p) < 0 && taken(p) >= 0;
        },
        Wanted());
    const double surface_m2 = 2 * (left_m3 / s.m());
    Add("caries left", {left_m3 * kMm3, s.must_cost}, "mm3", "caries_left_mm3",
        surface_m2 * quarter_m_ * kMm3, taken);
  }
}

}  // namespace enamel::station::lab
