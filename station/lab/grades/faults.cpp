#include "station/lab/grades/faults.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include "common/scene/preparation.h"
#include "common/scene/tooth_number.h"
#include "station/lab/grades/fault_maker.h"
#include "station/lab/grades/outline_by_mesh.h"

namespace enamel::station::lab {
namespace {

using cutting::Tissue;

constexpr double kShallow_m = 20e-6, kShave_m = 50e-6;
// Of what no eye sees, points at most.
constexpr double kMayCost = 3, kShavedMayCost = 0.1;

}  // namespace

FaultMaker::FaultMaker(const scene::BuiltScene& built, const scene::Exercise& exercise,
                       const Task& task, bool few)
    : volume_(built.volume), exercise_(exercise), task_(task), few_(few) {
  const double h = volume_.spec().voxel_m();
  quarter_m_ = h / 4;
  near_m_ = std::max(
      {exercise.target.leeway_side_um * 1e-6, exercise.target.leeway_bottom_um * 1e-6, 2 * h});
  const scene::PointUm& at = built.scene.landmarks.at(exercise.target.landmark);
  landmark_m_ = dvec3(at[0], at[1], at[2]) * 1e-6;
  grid_lo_m_ = volume_.spec().origin_m();
  grid_hi_m_ = grid_lo_m_ + dvec3(volume_.spec().voxels()) * h;
}

std::vector<Fault> FaultMaker::Make() {
  // Anything but a fault costs nothing.
  Add("none", {0, false}, "mm", "deviation_rms_mm", 1e-9, Wanted());
  Add("nothing", {0}, "%", "task_done_percent", 1e-9, NothingTaken);
  Add("everything removed", {100}, "%", "task_done_percent", 1e-6, EverythingTaken,
      Neighbours::kCut);
  switch (task_.kind) {
    case Task::Kind::kBox:
      MakeBox();
      break;
    case Task::Kind::kShape:
      MakeShape();
      break;
    case Task::Kind::kCrown:
      MakeCrown();
      break;
  }
  AddStoppedEarly();
  AddElsewhere();
  AddShaving();
  AddNeighbour();
  AddCaries();
  AddCriticalPairs();
  return std::move(out_);
}

Hollow FaultMaker::Wanted() const {
  return [task = task_](const dvec3& p) { return task.Distance_m(p); };
}

void FaultMaker::Add(std::string name, Size size, const char* unit, std::string metric,
                     double tolerance, Hollow taken, Neighbours neighbours) {
  out_.push_back({std::move(name), size.value, unit, std::move(metric), tolerance, size.must_cost,
                  std::move(taken), neighbours});
}
void FaultMaker::AddMm(std::string name, Size size, std::string metric, Hollow taken) {
  Add(std::move(name), size, "mm", std::move(metric), quarter_m_ * kMm, std::move(taken));
}
void FaultMaker::AddDegrees(std::string name, Size size, std::string metric, Hollow taken) {
  Add(std::move(name), size, "deg", std::move(metric), kAngleTolerance_deg, std::move(taken));
}

void FaultMaker::AddAllSurfaces(std::string metric_over, std::string metric_short,
                                const std::function<Hollow(double by_m)>& moved) {
  constexpr double kUnseen_mm = 0.08;
  AddMm("all_over", {kUnseen_mm, false}, std::move(metric_over), moved(kUnseen_mm / kMm));
  out_.back().may_cost = kMayCost;
  // Too little is + where the metric has no sign.
  const double size = metric_short == "floor_mm" ? -kUnseen_mm : kUnseen_mm;
  AddMm("all_short", {size, false}, std::move(metric_short), moved(-kUnseen_mm / kMm));
  out_.back().may_cost = kMayCost;
}

std::vector<FaultMaker::Size> FaultMaker::Sizes(std::initializer_list<double> all,
                                                double threshold) const {
  if (few_) return {{threshold, true}};
  std::vector<Size> out;
  for (double size : all) out.push_back({size, std::fabs(size) >= std::fabs(threshold)});
  return out;
}

// Pits under a level part of the surface, from lo to hi (equal z), exactly as deep as stated.
void FaultMaker::AddGouges(const dvec3& lo, const dvec3& hi) {
  for (const Size s : Sizes({0.1, 0.2, 0.3, 0.57}, 0.57)) {
    const dvec3 from = lo - dvec3(0, 0, s.m()), to(hi.x, hi.y, grid_hi_m_.z + 1);
    AddMm("gouge", s, "deepest_over_mm",
          Both(Wanted(), [=](const dvec3& p) { return BoxDistance_m(p, from, to); }));
  }
}
// A pillar of 1.4 x 1.4 mm left on a level part of the surface about `at`.
void FaultMaker::AddBump(const dvec3& at) {
  for (const Size s : Sizes({0.2, 0.5}, 0.5)) {
    const dvec3 lo = at - dvec3(0.7e-3, 0.7e-3, 1e-3), hi = at + dvec3(0.7e-3, 0.7e-3, s.m());
    AddMm("left", s, "most_left_mm", [=, wanted = Wanted()](const dvec3& p) {
      return std::max(wanted(p), -BoxDistance_m(p, lo, hi));
    });
  }
}

// An outline that is wider somewhere; the triangles of the uncut tooth measure how far.
void FaultMaker::AddMargin(Size size, Hollow taken) {
  size.value = kMm * OutlineOver_m(Surface(), Wanted(), taken);
  AddMm("margin", size, "outline_over_mm", std::move(taken));
}

// The task from above down, as far as half of it.
void FaultMaker::AddStoppedEarly() {
  const double h = volume_.spec().voxel_m(), all = TakenAbove(grid_lo_m_.z);
  if (!(all > 0)) return;
  double lo = grid_lo_m_.z, hi = grid_hi_m_.z;
  for (int i = 0; i < 30; ++i) {
    const double middle = 0.5 * (lo + hi);
    (TakenAbove(middle) > 0.5 * all ? lo : hi) = middle;
  }
  // Half way between two layers of points, which are at whole thirds of a voxel: each layer
  // represents as much above it as below.
  const double third = h / 3;
  const double z = grid_lo_m_.z + (std::floor((lo - grid_lo_m_.z) / third) + 0.5) * third;
  const double in_a_voxel = TakenAbove(z - h) - TakenAbove(z);
  Add("stopped early", {100 * TakenAbove(z) / all}, "%", "task_done_percent",
      // A level end is known to a quarter of a voxel, too.
      kShareTolerance_percent + 100 * in_a_voxel / 4 / all,
      [=, wanted = Wanted()](const dvec3& p) { return std::max(wanted(p), z - p.z); });
}
double FaultMaker::TakenAbove(double z) {
  if (heights_.empty()) {
    VolumeWhere_m3(
        volume_, grid_lo_m_, grid_hi_m_,
        [&](const dvec3& p, Tissue t) {
          if (t != Tissue::kNeighbour && task_.Distance_m(p) < 0 && volume_.DistanceAt_m(p) < 0) {
            heights_.push_back(static_cast<float>(p.z));
          }
          return false;
        },
        Wanted());
    std::sort(heights_.begin(), heights_.end());
  }
  return static_cast<double>(
      heights_.end() - std::upper_bound(heights_.begin(), heights_.end(), static_cast<float>(z)));
}

// A second hole, 0.8 mm wide, away from the task: beside it, or under a crown's shoulder.
void FaultMaker::AddElsewhere() {
  dvec3 lo, hi;
  if (!PlaceElsewhere(lo, hi)) return;
  auto hole = [=](const dvec3& p) { return BoxDistance_m(p, lo, hi); };
  const double size = VolumeWhere_m3(volume_, lo, hi, [&](const dvec3& p, Tissue t) {
    return t != Tissue::kNeighbour && hole(p) < 0 && task_.Distance_m(p) > near_m_;
  });
  const dvec3 e = glm::min(hi, grid_hi_m_) - lo;
  const double area = 2 * (e.x * e.y + e.y * e.z + e.z * e.x);
  Add("second hole", {size * kMm3}, "mm3", "outside_removed_mm3", area * quarter_m_ * kMm3,
      Both(Wanted(), hole));
}
bool FaultMaker::PlaceElsewhere(dvec3& lo, dvec3& hi) const {
  constexpr double kWide_m = 0.8e-3, kDeep_m = 1e-3;
  if (task_.kind == Task::Kind::kCrown) {
    // From buccal into the root's stem.
    const CrownCut::Section& s = task_.crown.at_shoulder;
    const double z = task_.crown.shoulder_z_m - near_m_ - 1e-3;
    double y = s.middle_y_m;
    while (volume_.DistanceAt_m({s.middle_x_m, y, z}) < 0 && y < grid_hi_m_.y) y += 0.05e-3;
    lo = {s.middle_x_m - kWide_m / 2, y - kDeep_m, z - kWide_m};
    hi = {s.middle_x_m + kWide_m / 2, y + 2e-3, z};
    return true;
  }
  // The side with the most tooth around the place.
  double best = 0;
  const scene::CavityTarget& t = exercise_.target;
  const double out = near_m_ + 0.3e-3 + kWide_m / 2;
  for (int side = 0; side < 4; ++side) {
    const double sign = side % 2 == 0 ? -1 : 1;
    dvec3 at = landmark_m_;
    at[side / 2] += sign * (t.half_size_um[static_cast<size_t>(side / 2)] * 1e-6 + out);
    const double top = TopNear(at);
    const dvec3 from(at.x - kWide_m / 2, at.y - kWide_m / 2, top - kDeep_m);
    const dvec3 to(at.x + kWide_m / 2, at.y + kWide_m / 2, top + 2e-3);
    const double volume = VolumeWhere_m3(volume_, from, to, [&](const dvec3& p, Tissue tissue) {
      return tissue != Tissue::kNeighbour && BoxDistance_m(p, from, to) < 0;
    });
    if (volume > best) best = volume, lo = from, hi = to;
  }
  return best > 0;
}

// Height of the tooth over a place.
double FaultMaker::TopNear(const dvec3& at) const {
  const double step = volume_.spec().voxel_m() / 2;
  double above = 1;
  for (double z = grid_hi_m_.z; z > grid_lo_m_.z; z -= step) {
    const double d = volume_.DistanceAt_m({at.x, at.y, z});
    if (d < 0) return z + step * d / (d - above);
    above = d;
  }
  return grid_lo_m_.z;
}

// A thin layer off all of the tooth above the task's bottom.
void FaultMaker::AddShaving() {
  // Of a crown nothing else is left above it.
  const double below = task_.kind == Task::Kind::kCrown ? 3e-3 : 0;
  const double bottom = landmark_m_.z - exercise_.target.depth_um * 1e-6 - below;
  const double h = volume_.spec().voxel_m();
  for (double layer_m : {kShallow_m, kShave_m}) {
    // Where phi is saturated, it is deep.
    auto shaving = [=, tooth = &volume_](const dvec3& p) {
      const double d = tooth->DistanceAt_m(p);
      return d < -3.9 * h ? 1.0 : std::max(-d - layer_m, bottom - p.z);
    };
    // By area: points are too far apart for so thin a layer. Only outside the task's neighbourhood,
    // which the metric counts separately.
    const double surface_m2 =
        AreaWhere_m2([&](const dvec3& p) { return p.z > bottom && FarFromCut(p); });
    const double size = surface_m2 * layer_m;
    Add("shaved by " + std::to_string(std::lround(layer_m * 1e6)) + " um", {size * kMm3, false},
        "mm3", "outside_removed_mm3", surface_m2 * quarter_m_ * kMm3, Both(Wanted(), shaving));
    out_.back().may_cost = kShavedMayCost;
  }
}
const surface::Mesh& FaultMaker::Surface() {
  if (surface_.triangles.empty()) surface_ = surface::ExtractSurface(volume_);
  return surface_;
}
// Area of the tooth's surface without neighbours, by triangles whose middle `counts` accepts.
double FaultMaker::AreaWhere_m2(const std::function<bool(const dvec3&)>& counts) {
  Surface();
  double sum = 0;
  for (const auto& corners : surface_.triangles) {
    if (surface_.tissue[corners[0]] == static_cast<uint8_t>(Tissue::kNeighbour)) continue;
    const dvec3 a(surface_.position_m[corners[0]]), b(surface_.position_m[corners[1]]),
        c(surface_.position_m[corners[2]]);
    if (!counts((a + b + c) / 3.0)) continue;
    const dvec3 n = glm::cross(b - a, c - a);
    sum += 0.5 * std::sqrt(Dot(n, n));
  }
  return sum;
}
// Farther from the task than the leeway, on either side of its surface; excludes the task itself.
bool FaultMaker::FarFromCut(const dvec3& p) const {
  if (task_.kind != Task::Kind::kBox) return task_.Distance_m(p) > near_m_;
  const BoxCavity& b = task_.box;
  const dvec3 half(b.half_x_m, b.half_y_m, 0);
  return BoxDistance_m(p, b.centre_m - half - dvec3(0, 0, b.depth_m),
                       b.centre_m + half + dvec3(0, 0, 1)) > near_m_;
}

std::optional<dvec3> FaultMaker::NearestNeighbour() {
  // Where a neighbour comes nearest above the middle of the target's height: a nick of 1 x 1 mm.
  const cutting::GridSpec& spec = volume_.spec();
  const double h = spec.voxel_m();
  const int mesial_x = task_.box.mesial_x;
  dvec3 nearest(0);
  double best = std::numeric_limits<double>::infinity();
  const double z = landmark_m_.z - 0.5e-3 * exercise_.target.depth_um * 1e-3;
  VolumeWhere_m3(
      volume_, {grid_lo_m_.x, -1e-3, z - h}, {grid_hi_m_.x, 1e-3, z + h},
      [&](const dvec3& p, Tissue t) {
        const double away = mesial_x * p.x;
        if (t == Tissue::kNeighbour && away > 0 && away < best && volume_.DistanceAt_m(p) < 0) {
          best = away, nearest = p;
        }
        return false;
      });
  if (!(best < 1)) return std::nullopt;
  return nearest;
}

void FaultMaker::AddNeighbour() {
  const auto nearest = NearestNeighbour();
  if (!nearest) return;
  for (const Size s : Sizes({0.1, 0.3, 0.5}, 0.3)) AddNick(*nearest, s);
}

void FaultMaker::AddNick(const dvec3& nearest, Size s) {
  const int mesial_x = task_.box.mesial_x;
  const dvec3 before = nearest - dvec3(mesial_x * 0.05e-3, 0.5e-3, 0.5e-3);
  const dvec3 beyond = nearest + dvec3(mesial_x * s.m(), 0.5e-3, 0.5e-3);
  const dvec3 lo = glm::min(before, beyond), hi = glm::max(before, beyond);
  auto nick = [=](const dvec3& p) { return BoxDistance_m(p, lo, hi); };
  const double size = VolumeWhere_m3(volume_, lo, hi, [&](const dvec3& p, Tissue t) {
    return t == Tissue::kNeighbour && nick(p) < 0;
  });
  const double area_m2 = 2 * 1e-6 + 4 * 1e-3 * s.m();
  // The task's own cut spares the neighbour, the nick does not.
  auto taken = [=, tooth = &volume_, wanted = Wanted()](const dvec3& p) {
    const bool spared = tooth->TissueAtPoint(p) == Tissue::kNeighbour;
    return std::min(spared ? 1.0 : wanted(p), nick(p));
  };
  Add("neighbour cut", {size * kMm3, s.must_cost}, "mm3", "neighbour_removed_mm3",
      area_m2 * quarter_m_ * kMm3, taken, Neighbours::kCut);
  out_.back().nick_mm = s.value;
}

double Task::Distance_m(const dvec3& p) const {
  switch (kind) {
    case Kind::kBox:
      return box.Distance_m(p);
    case Kind::kShape:
      return scene::PreparationDistance_m(shape, p);
    case Kind::kCrown:
      return crown.Distance_m(p);
  }
  return 1;
}

double Task::GrownDistance_m(const dvec3& p, double by_m) const {
  if (kind == Kind::kShape) return scene::PreparationDistance_m(shape, p, {by_m, by_m});
  if (kind == Kind::kCrown) return crown.Moved(by_m, by_m).Deeper(by_m).Distance_m(p);
  return box.Distance_m(p) - by_m;
}

Result<Task> TaskOf(const scene::BuiltScene& built, const scene::Exercise& exercise) {
  const scene::CavityTarget& target = exercise.target;
  const auto landmark = built.scene.landmarks.find(target.landmark);
  if (landmark == built.scene.landmarks.end()) {
    return Status(Code::kInvalidInput,
                  "the exercise's target hangs from landmark '" + target.landmark +
                      "', which scene '" + built.scene.name + "' does not have",
                  "landmark");
  }
  const dvec3 at = dvec3(landmark->second[0], landmark->second[1], landmark->second[2]) * 1e-6;
  Task out;
  ENAMEL_ASSIGN_OR_RETURN(scene::Preparation shape, scene::TargetShape(built.scene, target));
  if (shape.parts[0].outline == scene::PreparationPart::Outline::kStump) {
    out.kind = Task::Kind::kCrown;
    out.crown = CrownCutOf(shape.parts[0]);
    return out;
  }
  if (!target.parts.empty()) {
    out.kind = Task::Kind::kShape;
    out.shape = std::move(shape);
    return out;
  }
  out.box = {
      at, target.half_size_um[0] * 1e-6,    target.half_size_um[1] * 1e-6, target.depth_um * 1e-6,
      {}, scene::MesialX(built.scene.tooth)};
  // There is no wall where the box ends in the open.
  out.open_mesial = target.landmark == "mesial_box";
  return out;
}

std::vector<Fault> FaultsOf(const scene::BuiltScene& built, const scene::Exercise& exercise,
                            const Task& task, bool few) {
  return FaultMaker(built, exercise, task, few).Make();
}

}  // namespace enamel::station::lab
