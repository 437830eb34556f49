#include "station/lab/grades/faults.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include "common/scene/preparation.h"
#include "common/surface/surface.h"

namespace enamel::station::lab {
namespace {

using cutting::Tissue;

constexpr double kMm = 1e3, kMm3 = 1e9;
constexpr double kPi = 3.14159265358979323846;
constexpr double kAngleTolerance_deg = 0.5, kShareTolerance_percent = 1;
constexpr double kShallow_m = 20e-6, kShave_m = 50e-6;
constexpr std::array<const char*, 4> kWalls = {"mesial", "distal", "buccal", "lingual"};

double Slope(double degrees) { return std::tan(degrees * kPi / 180); }

class Faults {
 public:
  Faults(const scene::BuiltScene& built, const scene::Exercise& exercise, const Task& task,
         bool few)
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

  std::vector<Fault> Make() {
    Add("none", 0, "mm", "deviation_rms_mm", 1e-9, Wanted());
    Add("nothing", 0, "%", "task_done_percent", 1e-9, NothingTaken);
    Add("everything removed", 100, "%", "task_done_percent", 1e-6, EverythingTaken,
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
    return std::move(out_);
  }

 private:
  using List = std::initializer_list<double>;

  Hollow Wanted() const {
    return [task = task_](const dvec3& p) { return task.Distance_m(p); };
  }
  void Add(std::string name, double size, const char* unit, std::string metric, double tolerance,
           Hollow taken, Neighbours neighbours = Neighbours::kSpared) {
    out_.push_back(
        {std::move(name), size, unit, std::move(metric), tolerance, std::move(taken), neighbours});
  }
  void AddMm(std::string name, double size_m, std::string metric, Hollow taken) {
    Add(std::move(name), size_m * kMm, "mm", std::move(metric), quarter_m_ * kMm, std::move(taken));
  }
  // All of `all`, or the one that is taken as the threshold.
  std::vector<double> Sizes(List all, double threshold) const {
    if (few_) return {threshold};
    return all;
  }

  // --- a box ---

  Hollow BoxWith(size_t face, const Face& as) const {
    BoxCavity box = task_.box;
    box.faces[face] = as;
    return [box](const dvec3& p) { return box.Distance_m(p); };
  }
  bool HasWall(size_t wall) const { return wall != 0 || !task_.open_mesial; }

  void MakeBox() {
    for (size_t w = 0; w < kWalls.size(); ++w) {
      if (!HasWall(w)) continue;
      const std::string name = kWalls[w];
      for (double mm : Sizes({-1, -0.5, -0.3, -0.1, -0.05, 0.05, 0.1, 0.3, 0.5, 1}, 0.3)) {
        AddMm("wall_" + name, mm / kMm, "wall_" + name + "_mm", BoxWith(w, {.moved_m = mm / kMm}));
      }
      for (double deg : Sizes({1, 5, 10, 20}, 10)) {
        Add("tilt_" + name, deg, "deg", "tilt_" + name + "_deg", kAngleTolerance_deg,
            BoxWith(w, {.slope = Slope(deg)}));
      }
    }
    const size_t wall = 1;  // every box has a distal one
    for (double deg : Sizes({5, 10, 20}, 10)) {
      Add("undercut", deg, "deg", "undercut_deg", kAngleTolerance_deg,
          BoxWith(wall, {.slope = -Slope(deg)}));
      BoxCavity box = task_.box;
      for (size_t w = 0; w < kWalls.size(); ++w) {
        if (HasWall(w)) box.faces[w].slope = Slope(deg);
      }
      Add("taper", deg, "deg", "wall_tilt_deg", kAngleTolerance_deg,
          [box](const dvec3& p) { return box.Distance_m(p); });
    }
    // The height of a wave whose root mean square is the size. Where caries is followed, walls are
    // as they come.
    for (double mm : Sizes({0.02, 0.05, 0.1, 0.2}, 0.1)) {
      if (HasCaries()) break;
      const Face wave{.wave_m = std::sqrt(2.0) * mm / kMm};
      AddMm("waviness", mm / kMm, "wall_waviness_mm", BoxWith(wall, wave));
      AddMm("floor_waviness", mm / kMm, "floor_waviness_mm", BoxWith(4, wave));
    }
    for (double mm : Sizes({-0.5, -0.3, -0.1, -0.05, 0.05, 0.1, 0.3, 0.5, 1}, 0.3)) {
      AddMm("floor", mm / kMm, "floor_mm", BoxWith(4, {.moved_m = mm / kMm}));
    }
    for (double deg : Sizes({1, 5, 15}, 5)) {
      if (HasCaries()) break;  // its floor is where the lesion ends
      Add("tilt_floor", deg, "deg", "tilt_floor_deg", kAngleTolerance_deg,
          BoxWith(4, {.slope = Slope(deg)}));
    }
    // A pit of 0.6 x 0.6 mm in the floor's corner.
    const BoxCavity& b = task_.box;
    const dvec3 corner = b.centre_m + dvec3(-b.half_x_m, -b.half_y_m, -b.depth_m);
    AddGouges(corner, corner + dvec3(0.6e-3, 0.6e-3, 0));
    // The rim of the distal wall, down to 0.6 mm, is farther out.
    for (double mm : Sizes({0.2, 0.3, 0.5}, 0.3)) {
      const double m = mm / kMm;
      const double top = TopNear(b.centre_m - dvec3(b.half_x_m, 0, 0));
      const dvec3 lo(b.centre_m.x - b.half_x_m - m, b.centre_m.y - b.half_y_m, top - 0.6e-3);
      const dvec3 hi(b.centre_m.x, b.centre_m.y + b.half_y_m, grid_hi_m_.z + 1);
      AddMm("margin", OutlineMovedBy_m(m), "outline_over_mm",
            Both(Wanted(), [=](const dvec3& p) { return BoxDistance_m(p, lo, hi); }));
    }
  }

  // How far the outline of the distal wall moves on the tooth's slope when the wall is moved: along
  // the wall from each point to the nearest of the moved outline, and of these what 5 % of the whole
  // outline reach.
  double OutlineMovedBy_m(double out_m) const {
    constexpr int kPoints = 81;
    const BoxCavity& b = task_.box;
    std::vector<dvec3> before, after;
    for (int i = 0; i < kPoints; ++i) {
      const double y = b.centre_m.y + b.half_y_m * (2.0 * i / (kPoints - 1) - 1);
      const double x = b.centre_m.x - b.half_x_m;
      before.emplace_back(x, y, TopNear({x, y, 0}));
      after.emplace_back(x - out_m, y, TopNear({x - out_m, y, 0}));
    }
    std::vector<double> moved;
    for (const dvec3& p : before) {
      double nearest = std::numeric_limits<double>::infinity();
      for (const dvec3& q : after) nearest = std::min(nearest, Dot(p - q, p - q));
      moved.push_back(std::sqrt(nearest));
    }
    std::sort(moved.begin(), moved.end(), std::greater<>());
    const double share = 0.05 * 2 * (b.half_x_m + b.half_y_m) / b.half_y_m;
    return moved[static_cast<size_t>(share * (kPoints - 1))];
  }

  // --- a shape on the block ---

  void MakeShape() {
    auto grown = [&](double side_m, double floor_m) {
      return [shape = task_.shape, by = scene::Growth{side_m, floor_m}](const dvec3& p) {
        return scene::PreparationDistance_m(shape, p, by);
      };
    };
    if (task_.shape.parts.at(0).relief.step_um != 0) return MakeFace(grown);
    const double corner = CornerMovesBy() - 1;
    for (double mm : Sizes({0.05, 0.1, 0.3, 0.5}, 0.3)) {
      for (double way : {1.0, -1.0}) {
        Add(way > 0 ? "walls_over" : "walls_short", mm, "mm", "deviation_p95_mm",
            quarter_m_ * kMm + corner * mm, grown(way * mm / kMm, 0));
      }
      AddMm("floor_over", mm / kMm, "deepest_over_mm", grown(0, mm / kMm));
      AddMm("floor_short", mm / kMm, "most_left_mm", grown(0, -mm / kMm));
    }
    const dvec3 bottom = LevelFloor_m();
    AddGouges(bottom - dvec3(0.3e-3, 0.3e-3, 0), bottom + dvec3(0.3e-3, 0.3e-3, 0));
    AddBump(bottom);
  }

  // How far an upright corner goes when its walls move by 1: where two parts meet at a right angle, a
  // corner of the tooth is left; a polygon has its own.
  double CornerMovesBy() const {
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

  // The middle of the bottom of the first part that is level for 0.7 mm about it: where another part
  // goes deeper, a pit or a pillar there would have another size.
  dvec3 LevelFloor_m() const {
    constexpr double kAbout_m = 0.7e-3, kUnder_m = 1e-6;
    auto middle = [](const scene::PreparationPart& part) {
      return dvec3(part.top_um[0], part.top_um[1], part.top_um[2] - part.depth_um) * 1e-6;
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
  template <typename Grown>
  void MakeFace(const Grown& grown) {
    const scene::PreparationPart& part = task_.shape.parts[0];
    for (double mm : Sizes({0.05, 0.1, 0.2, 0.3}, 0.2)) {
      AddMm("floor_over", mm / kMm, "deepest_over_mm", grown(0, mm / kMm));
      AddMm("floor_short", mm / kMm, "most_left_mm", grown(0, -mm / kMm));
    }
    auto over = [part](const dvec3& p) { return scene::HeightOverRelief_m(part, p); };
    const dvec3 middle = dvec3(part.top_um[0], part.top_um[1], 0) * 1e-6;
    AddFollowing(middle, over, [over](double by_m) -> Hollow {
      return [=](const dvec3& p) { return by_m - over(p); };
    });
  }
  // A pit of 0.8 x 0.8 mm and a pillar of 1.4 x 1.4 mm about a place, their ends so far below and above
  // a surface as they are said to be. `over`: height over it; `raised`: the task with it so much
  // higher.
  template <typename Over, typename Raised>
  void AddFollowing(const dvec3& at, const Over& over, const Raised& raised) {
    auto square = [at](double half_m) {
      return [=](const dvec3& p) {
        return std::max(std::fabs(p.x - at.x), std::fabs(p.y - at.y)) - half_m;
      };
    };
    for (double mm : Sizes({0.1, 0.2, 0.3, 0.57}, 0.3)) {
      AddMm("gouge", mm / kMm, "deepest_over_mm",
            Both(Wanted(), [=, in = square(0.4e-3)](const dvec3& p) {
              return std::max(in(p), -over(p) - mm / kMm);
            }));
    }
    for (double mm : Sizes({0.2, 0.4}, 0.4)) {
      AddMm("left", mm / kMm, "most_left_mm",
            [in = square(0.7e-3), wanted = Wanted(), less = raised(mm / kMm)](const dvec3& p) {
              return std::max(wanted(p), std::min(less(p), -in(p)));
            });
    }
  }

  // --- a crown ---

  void MakeCrown() {
    auto moved = [&](double in_m, double lower_m) {
      return [cut = task_.crown.Moved(in_m, lower_m)](const dvec3& p) { return cut.Distance_m(p); };
    };
    for (double mm : Sizes({0.05, 0.1, 0.3, 0.5}, 0.3)) {
      AddMm("walls_over", mm / kMm, "deviation_p95_mm", moved(mm / kMm, 0));
      AddMm("walls_short", mm / kMm, "deviation_p95_mm", moved(-mm / kMm, 0));
      AddMm("top_over", mm / kMm, "deepest_over_mm", moved(0, mm / kMm));
      AddMm("top_short", mm / kMm, "most_left_mm", moved(0, -mm / kMm));
    }
    auto cut = [](const CrownCut& as) { return [as](const dvec3& p) { return as.Distance_m(p); }; };
    for (double deg : Sizes({20, 30, 45}, 30)) {
      Add("convergence", deg, "deg", "convergence_mesiodistal_deg", kAngleTolerance_deg,
          cut(task_.crown.Converging(deg)));
    }
    // Farther in, or their walls would come out of the tooth's side below the top.
    const CrownCut slim = task_.crown.Moved(0.6e-3, 0);
    for (double deg : Sizes({-3, -5, -10}, -10)) {
      Add("undercut", deg, "deg", "convergence_mesiodistal_deg", kAngleTolerance_deg,
          cut(slim.Converging(deg)));
    }
    for (double deg : Sizes({10, 12, 15}, 12)) {
      const CrownCut leaning = slim.Leaning(deg);
      Add("lean", leaning.Lean_deg(), "deg", "crown_axis_deg", kAngleTolerance_deg, cut(leaning));
    }
    for (double mm : Sizes({-0.5, -0.3, -0.1, 0.1, 0.3, 0.5}, 0.3)) {
      AddMm("finish_line", mm / kMm, "finish_depth_mm", cut(task_.crown.Deeper(mm / kMm)));
    }
    for (double mm : Sizes({0.05, 0.1, 0.2}, 0.2)) {
      CrownCut wavy = task_.crown;
      wavy.wave_m = std::sqrt(2.0) * mm / kMm;
      AddMm("finish_waviness", mm / kMm, "finish_waviness_mm", cut(wavy));
    }
    const CrownCut& c = task_.crown;
    if (c.table) {
      auto raised = [&c](double by_m) -> Hollow {
        CrownCut higher = c;
        higher.table_lower_m -= by_m;
        return [higher](const dvec3& p) { return higher.Distance_m(p); };
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

  // --- of all ---

  // Pits under a level part of the surface, from lo to hi (equal z): as deep as they are said to be.
  void AddGouges(const dvec3& lo, const dvec3& hi) {
    for (double mm : Sizes({0.1, 0.2, 0.3, 0.57}, 0.3)) {
      const dvec3 from = lo - dvec3(0, 0, mm / kMm), to(hi.x, hi.y, grid_hi_m_.z + 1);
      AddMm("gouge", mm / kMm, "deepest_over_mm",
            Both(Wanted(), [=](const dvec3& p) { return BoxDistance_m(p, from, to); }));
    }
  }
  // A pillar of 1.4 x 1.4 mm left on a level part of the surface about `at`.
  void AddBump(const dvec3& at) {
    for (double mm : Sizes({0.2, 0.5}, 0.5)) {
      const dvec3 lo = at - dvec3(0.7e-3, 0.7e-3, 1e-3), hi = at + dvec3(0.7e-3, 0.7e-3, mm / kMm);
      AddMm("left", mm / kMm, "most_left_mm", [=, wanted = Wanted()](const dvec3& p) {
        return std::max(wanted(p), -BoxDistance_m(p, lo, hi));
      });
    }
  }

  // The task from above down, as far as half of it.
  void AddStoppedEarly() {
    double lo = -1, hi = 1;
    const double all = TakenAbove(-1);
    if (!(all > 0)) return;
    for (int i = 0; i < 12; ++i) {
      const double middle = 0.5 * (lo + hi);
      (TakenAbove(middle) > 0.5 * all ? lo : hi) = middle;
    }
    const double z = lo;
    Add("stopped early", 100 * TakenAbove(z) / all, "%", "task_done_percent",
        // A level end is known to a quarter of a voxel, too.
        kShareTolerance_percent + 100 * (TakenAbove(z - quarter_m_) - TakenAbove(z)) / all,
        [=, wanted = Wanted()](const dvec3& p) { return std::max(wanted(p), z - p.z); });
  }
  double TakenAbove(double z) {
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

  // A second hole, 0.8 mm wide, where the task is not: beside it, or under a crown's shoulder.
  void AddElsewhere() {
    dvec3 lo, hi;
    if (!PlaceElsewhere(lo, hi)) return;
    auto hole = [=](const dvec3& p) { return BoxDistance_m(p, lo, hi); };
    const double size = VolumeWhere_m3(volume_, lo, hi, [&](const dvec3& p, Tissue t) {
      return t != Tissue::kNeighbour && hole(p) < 0 && task_.Distance_m(p) > near_m_;
    });
    const dvec3 e = glm::min(hi, grid_hi_m_) - lo;
    const double area = 2 * (e.x * e.y + e.y * e.z + e.z * e.x);
    Add("second hole", size * kMm3, "mm3", "outside_removed_mm3", area * quarter_m_ * kMm3,
        Both(Wanted(), hole));
  }
  bool PlaceElsewhere(dvec3& lo, dvec3& hi) const {
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
    // Whichever side has most of the tooth about the place.
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

  double TopNear(const dvec3& at) const {
    const double h = volume_.spec().voxel_m();
    double z = grid_hi_m_.z;
    while (z > grid_lo_m_.z && volume_.DistanceAt_m({at.x, at.y, z}) >= 0) z -= h / 2;
    return z;
  }

  // A thin layer off all of the tooth above the task's bottom.
  void AddShaving() {
    // Of a crown nothing else is left above it.
    const double below = task_.kind == Task::Kind::kCrown ? 3e-3 : 0;
    const double bottom = landmark_m_.z - exercise_.target.depth_um * 1e-6 - below;
    const double h = volume_.spec().voxel_m();
    for (double layer_m : {kShallow_m, kShave_m}) {
      // Where phi says no more, it is deep.
      auto shaving = [=, tooth = &volume_](const dvec3& p) {
        const double d = tooth->DistanceAt_m(p);
        return d < -3.9 * h ? 1.0 : std::max(-d - layer_m, bottom - p.z);
      };
      // By area: points are too far apart to see so thin a layer. Only what the task's neighbourhood
      // does not hold: the metric counts that apart.
      const double surface_m2 =
          AreaWhere_m2([&](const dvec3& p) { return p.z > bottom && FarFromCut(p); });
      const double size = surface_m2 * layer_m;
      Add("shaved by " + std::to_string(std::lround(layer_m * 1e6)) + " um", size * kMm3, "mm3",
          "outside_removed_mm3", surface_m2 * quarter_m_ * kMm3, Both(Wanted(), shaving));
    }
  }
  // Of the tooth's surface, neighbours apart, by triangles whose middle `counts` accepts.
  double AreaWhere_m2(const std::function<bool(const dvec3&)>& counts) {
    if (surface_.triangles.empty()) surface_ = surface::ExtractSurface(volume_);
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
  // Farther from the task than the leeway, on either side of its surface: what is wanted is not
  // counted.
  bool FarFromCut(const dvec3& p) const {
    if (task_.kind != Task::Kind::kBox) return task_.Distance_m(p) > near_m_;
    const BoxCavity& b = task_.box;
    const dvec3 half(b.half_x_m, b.half_y_m, 0);
    return BoxDistance_m(p, b.centre_m - half - dvec3(0, 0, b.depth_m),
                         b.centre_m + half + dvec3(0, 0, 1)) > near_m_;
  }

  void AddNeighbour() {
    // Where a neighbour comes nearest above the middle of the target's height: a nick of 1 x 1 mm.
    const cutting::GridSpec& spec = volume_.spec();
    const double h = spec.voxel_m();
    dvec3 nearest(0);
    double best = std::numeric_limits<double>::infinity();
    const double z = landmark_m_.z - 0.5e-3 * exercise_.target.depth_um * 1e-3;
    VolumeWhere_m3(
        volume_, {grid_lo_m_.x, -1e-3, z - h}, {grid_hi_m_.x, 1e-3, z + h},
        [&](const dvec3& p, Tissue t) {
          if (t == Tissue::kNeighbour && p.x > 0 && p.x < best && volume_.DistanceAt_m(p) < 0) {
            best = p.x, nearest = p;
          }
          return false;
        });
    if (!(best < 1)) return;
    for (double mm : Sizes({0.1, 0.3, 0.5}, 0.3)) {
      const dvec3 lo = nearest - dvec3(0.05e-3, 0.5e-3, 0.5e-3);
      const dvec3 hi = nearest + dvec3(mm / kMm, 0.5e-3, 0.5e-3);
      auto nick = [=](const dvec3& p) { return BoxDistance_m(p, lo, hi); };
      const double size = VolumeWhere_m3(volume_, lo, hi, [&](const dvec3& p, Tissue t) {
        return t == Tissue::kNeighbour && nick(p) < 0;
      });
      const double area_m2 = 2 * 1e-6 + 4 * 1e-3 * mm / kMm;
      // The task's own cut spares the neighbour, the nick does not.
      auto taken = [=, tooth = &volume_, wanted = Wanted()](const dvec3& p) {
        const bool spared = tooth->TissueAtPoint(p) == Tissue::kNeighbour;
        return std::min(spared ? 1.0 : wanted(p), nick(p));
      };
      Add("neighbour cut", size * kMm3, "mm3", "neighbour_removed_mm3", area_m2 * quarter_m_ * kMm3,
          taken, Neighbours::kCut);
    }
  }

  bool HasCaries() const { return exercise_.target.landmark == "caries"; }
  // Caries under the task's floor's last part is left.
  void AddCaries() {
    if (!HasCaries() || task_.kind != Task::Kind::kBox) return;
    for (double mm : Sizes({0.2, 0.4, 0.6}, 0.4)) {
      BoxCavity box = task_.box;
      box.faces[4].moved_m = -mm / kMm;
      auto taken = [box](const dvec3& p) { return box.Distance_m(p); };
      const double size = VolumeWhere_m3(
          volume_, grid_lo_m_, grid_hi_m_,
          [&](const dvec3& p, Tissue t) {
            return t == Tissue::kCaries && task_.Distance_m(p) < 0 && taken(p) >= 0;
          },
          Wanted());
      const double surface = 2 * (size / (mm / kMm));
      Add("caries left", size * kMm3, "mm3", "caries_left_mm3", surface * quarter_m_ * kMm3, taken);
    }
  }

  const cutting::Volume& volume_;
  const scene::Exercise& exercise_;
  const Task& task_;
  const bool few_;
  double quarter_m_ = 0, near_m_ = 0;
  dvec3 landmark_m_{0}, grid_lo_m_{0}, grid_hi_m_{0};
  surface::Mesh surface_;       // of the tooth, once somebody asks for areas
  std::vector<float> heights_;  // of points of the task
  std::vector<Fault> out_;
};

}  // namespace

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
      at, target.half_size_um[0] * 1e-6, target.half_size_um[1] * 1e-6, target.depth_um * 1e-6, {}};
  // No wall stands where the box ends in the open.
  out.open_mesial = target.landmark == "mesial_box";
  return out;
}

std::vector<Fault> FaultsOf(const scene::BuiltScene& built, const scene::Exercise& exercise,
                            const Task& task, bool few) {
  return Faults(built, exercise, task, few).Make();
}

}  // namespace enamel::station::lab
