#include "common/scoring/causes/causes.h"

#include <algorithm>
#include <cmath>

#include "common/scoring/causes/explained.h"

namespace enamel::scoring {
namespace {

constexpr double kMm = 1e3, kMm3 = 1e9;
// Charges that differ by less are left at the value.
constexpr double kLeast_mm = 0.02, kLeast_deg = 0.5, kLeast_mm3 = 0.01, kLeast_percent = 0.2;

constexpr std::array<std::string_view, kPartCount> kOffsets = {
    "wall_mesial_mm", "wall_distal_mm", "wall_buccal_mm", "wall_lingual_mm", "floor_mm"};
constexpr std::string_view kCloseness = "deviation_rms_mm", kSound = "sound_removed_mm3",
                           kDone = "task_done_percent";

bool Made(const WallFigures& w) { return w.in_task && w.made; }

// A sum by patch, and whose is the most.
class Shares {
 public:
  explicit Shares(const Explained& explained) : explained_(explained) {
    of_.resize(explained.patches().size());
  }
  void Add(const Patch* patch, double amount) {
    if (patch == nullptr) return;
    of_[static_cast<size_t>(patch - explained_.patches().data())] += amount;
    sum_ += amount;
  }
  double sum() const { return sum_; }
  // The metric of the wall or floor; of another patch empty.
  std::string_view Most() const {
    const auto most = std::ranges::max_element(of_) - of_.begin();
    const Part part = explained_.patches()[static_cast<size_t>(most)].part;
    return part == kNoPart ? std::string_view() : kOffsets[part];
  }

 private:
  const Explained& explained_;
  std::vector<double> of_;
  double sum_ = 0;
};

class Charges {
 public:
  Charges(const Measured& measured, const CauseInputs& inputs)
      : m_(measured),
        in_(inputs),
        // A stump has a top and a shoulder where a cavity has a floor: no walls and no floor here.
        walls_(measured.crown.in_task ? Walls{} : measured.walls),
        explained_(walls_, inputs) {}

  std::vector<Charge> Find() {
    Offsets();
    Turn();
    Tilts();
    Waves();
    Surfaces();
    Outline();
    Volumes();
    Cover();
    return std::move(out_);
  }

 private:
  bool IsCharged(std::string_view name) const {
    return std::ranges::find(out_, name, &Charge::name) != out_.end();
  }
  void Add(std::string_view name, double value, double charged, double least,
           std::initializer_list<std::string_view> under) {
    if (!(std::fabs(value - charged) > least)) return;
    Charge charge{name, charged, {}};
    for (std::string_view metric : under) {
      if (!metric.empty() && metric != name) charge.under.push_back(metric);
    }
    if (!charge.under.empty()) out_.push_back(std::move(charge));
  }

  // A wall that leans about a line between its foot and its rim is off by its lean alone.
  static double OffsetOf_m(const Sheet& sheet) {
    const double foot = sheet.AtHeight_m(sheet.s_least_m), rim = sheet.AtHeight_m(sheet.s_most_m);
    if (foot * rim <= 0) return 0;
    return std::fabs(foot) < std::fabs(rim) ? foot : rim;
  }

  // Opposite walls that lie off the same way are one shift: charged where the cut went too far.
  void Offsets() {
    for (size_t p = 0; p < kFloor; ++p) {
      const double offset = walls_[p].offset_m, least = OffsetOf_m(walls_[p].over);
      if (Made(walls_[p]) && std::fabs(least) < std::fabs(offset))
        Add(kOffsets[p], offset * kMm, least * kMm, kLeast_mm,
            {walls_[p].tilt_deg < 0 && walls_[p].opens_deg < 0 ? "undercut_deg" : "",
             "wall_tilt_deg"});
    }
    for (const auto& [one, other] : {std::pair(kMesial, kDistal), std::pair(kBuccal, kLingual)}) {
      const WallFigures &a = walls_[one], &b = walls_[other];
      if (!Made(a) || !Made(b) || a.offset_m * b.offset_m >= 0) continue;
      if (IsCharged(kOffsets[one]) || IsCharged(kOffsets[other])) continue;
      const Part over = a.offset_m > 0 ? one : other, short_of = a.offset_m > 0 ? other : one;
      const double far = walls_[over].offset_m, back = walls_[short_of].offset_m;
      // Both are known to a fraction of a voxel: of the same shift nothing may be left.
      const double rest = back + std::min(-back, far);
      Add(kOffsets[short_of], back * kMm, rest * kMm, kLeast_mm, {kOffsets[over]});
    }
  }

  // A cut that is turned has walls whose medians are right. The one that is farthest off on the mean
  // is charged with that.
  void Turn() {
    const Patch* most = nullptr;
    double most_m = 0;
    for (const Patch& patch : explained_.patches()) {
      if (patch.part >= kFloor || patch.vertices.empty()) continue;
      double sum = 0;
      for (size_t i : patch.vertices) {
        const double t = Dot(dvec3(in_.reference.mesh->position_m[i]), patch.sheet.along);
        sum += (*in_.reference.areas_m2)[i] *
               std::fabs(patch.sheet.plane.c * (t - patch.sheet.plane.t0));
      }
      if (!(sum > most_m * patch.area_m2)) continue;
      most = &patch, most_m = sum / patch.area_m2;
    }
    if (most == nullptr) return;
    const double offset_mm = walls_[most->part].offset_m * kMm;
    if (most_m * kMm > std::fabs(offset_mm) + kLeast_mm)
      out_.push_back({kOffsets[most->part], most_m * kMm, {}});
  }

  // A wall that leans in is judged as undercut, and a cut that leans as a whole by its worst wall.
  void Tilts() {
    double whole = 0;
    for (const auto& [one, other] : {std::pair(kMesial, kDistal), std::pair(kBuccal, kLingual)}) {
      const WallFigures &a = walls_[one], &b = walls_[other];
      if (!Made(a) || !Made(b) || a.tilt_deg * b.tilt_deg >= 0) continue;
      whole = std::max(whole, std::min(std::fabs(a.tilt_deg), std::fabs(b.tilt_deg)));
    }
    double most = 0, rest = 0, leans_in = 0;
    for (size_t p = 0; p < kFloor; ++p) {
      const WallFigures& w = walls_[p];
      if (!w.in_task) continue;
      if (!w.made) return;
      const double tilt = std::fabs(w.tilt_deg);
      most = std::max(most, tilt);
      leans_in = std::max(leans_in, -w.opens_deg);
      // What leans over the cavity is undercut_deg's; the rest of its tilt is not.
      const double inwards = w.tilt_deg < 0 ? std::max(0.0, -w.opens_deg) : 0;
      rest = std::max(
          rest, w.tilt_deg < 0 ? tilt - std::min(tilt, inwards) : std::max(0.0, tilt - whole));
    }
    Add("wall_tilt_deg", most, rest, kLeast_deg, {leans_in > 0 ? "undercut_deg" : ""});
    const WallFigures& floor = walls_[kFloor];
    if (Made(floor) && whole > 0) {
      Add("tilt_floor_deg", floor.tilt_deg, std::max(0.0, floor.tilt_deg - whole), kLeast_deg,
          {leans_in > 0 ? "undercut_deg" : "", "wall_tilt_deg"});
    }
  }

  // A gouge, a step or a rest is no wave.
  void Waves() {
    double most = 0, waves = 0;
    for (size_t p = 0; p < kFloor; ++p) {
      if (!Made(walls_[p])) continue;
      most = std::max(most, walls_[p].waviness_m);
      waves = std::max(waves, walls_[p].over.waves_m);
    }
    Add("wall_waviness_mm", most * kMm, std::min(most, waves) * kMm, 0,
        {"deepest_over_mm", kCloseness});
    const WallFigures& floor = walls_[kFloor];
    if (Made(floor)) {
      Add("floor_waviness_mm", floor.waviness_m * kMm,
          std::min(floor.waviness_m, floor.over.waves_m) * kMm, 0, {"deepest_over_mm", kCloseness});
    }
  }

  // The distances between the surfaces, less what walls and floor explain.
  void Surfaces() {
    Shares over(explained_);
    std::vector<float> deeper = in_.attempt_m;
    const surface::Mesh& made = *in_.attempt.mesh;
    for (size_t i = 0; i < deeper.size(); ++i) {
      if (!(deeper[i] > kLeast_mm / kMm)) continue;
      const double d = deeper[i], by = explained_.At_m(dvec3(made.position_m[i]), d, false);
      deeper[i] = static_cast<float>(std::max(0.0, d - by));
    }
    std::vector<float> rest = in_.reference_m;
    Shares left(explained_);
    const surface::Mesh& wanted = *in_.reference.mesh;
    for (size_t i = 0; i < rest.size(); ++i) {
      if (!(*in_.reference.cut)[i] || !(std::fabs(rest[i]) > kLeast_mm / kMm)) continue;
      const bool is_left = rest[i] > 0;
      const double d = std::fabs(rest[i]);
      const double by = std::min(d, explained_.At_m(dvec3(wanted.position_m[i]), d, is_left));
      (is_left ? left : over).Add(explained_.PatchOf(i), by * (*in_.reference.areas_m2)[i]);
      rest[i] = static_cast<float>(is_left ? d - by : by - d);
    }
    const double deepest_mm = m_.deepest_over.depth_m * kMm;
    Add("deepest_over_mm", deepest_mm,
        std::min(deepest_mm, DeepestOver(in_.attempt, deeper).depth_m * kMm), kLeast_mm,
        {over.Most(), kCloseness, kSound});
    const DeviationFigures spots = MeasureDeviation(in_.reference, rest);
    const double left_mm = m_.deviation.most_left_m * kMm, p95_mm = m_.deviation.p95_m * kMm;
    Add("most_left_mm", left_mm, std::min(left_mm, spots.most_left_m * kMm), kLeast_mm,
        {left.Most(), kCloseness, kDone});
    Add("deviation_p95_mm", p95_mm, std::min(p95_mm, spots.p95_m * kMm), kLeast_mm,
        {kCloseness, (over.sum() > left.sum() ? over : left).Most()});
    Closeness();
    most_over_ = over.Most(), most_left_ = left.Most();
  }

  // Of the root mean square, which is the whole, only what other metrics are about is left out:
  // slopes, or waves, whichever is more.
  void Closeness() {
    enum Kind { kWallSlope, kFloorSlope, kWallWave, kFloorWave, kKinds };
    std::array<double, kKinds> squares{};
    double area = 0, all = 0;
    for (size_t i = 0; i < in_.reference_m.size(); ++i) {
      if (!(*in_.reference.cut)[i]) continue;
      const double weight = (*in_.reference.areas_m2)[i], d = in_.reference_m[i];
      area += weight, all += weight * d * d;
      const Patch* patch = explained_.PatchOf(i);
      if (patch == nullptr) continue;
      const Sheet& sheet = patch->sheet;
      const dvec3 p(in_.reference.mesh->position_m[i]);
      const double slope = sheet.At_m(p) - OffsetOf_m(sheet);
      squares[patch->upright() ? kWallSlope : kFloorSlope] += weight * slope * slope;
      squares[patch->upright() ? kWallWave : kFloorWave] += weight * sheet.waves_m * sheet.waves_m;
    }
    if (!(area > 0)) return;
    const auto most = std::ranges::max_element(squares) - squares.begin();
    const double rms_mm = std::sqrt(std::max(0.0, all - squares[most]) / area) * kMm;
    const double value = m_.deviation.rms_m * kMm;
    using Names = std::initializer_list<std::string_view>;
    const std::array<Names, kKinds> under = {Names{"wall_tilt_deg", "convergence_mesiodistal_deg"},
                                             {"tilt_floor_deg"},
                                             {"wall_waviness_mm"},
                                             {"floor_waviness_mm", "finish_waviness_mm"}};
    Add(kCloseness, value, std::min(value, rms_mm), kLeast_mm, under[most]);
  }

  void Outline() {
    if (!m_.outline.in_task || m_.outline.over_at.empty()) return;
    std::vector<WeightedValue> rest;
    for (const OutlineFigures::Over& o : m_.outline.over_at)
      rest.push_back({std::max(0.0, o.by_m - explained_.At_m(o.at_m, o.by_m, false)), 1});
    for (size_t i = rest.size(); i < m_.outline.points; ++i) rest.push_back({0, 1});
    const double value = m_.outline.over_m * kMm;
    Add("outline_over_mm", value, std::min(value, WeightedQuantile(std::move(rest), 0.95) * kMm),
        kLeast_mm, {most_over_, kCloseness});
  }

  // What a wall or floor that lies elsewhere leaves or takes.
  void Volumes() {
    const double voxel_m = in_.reference.volume->spec().voxel_m();
    constexpr double kMeanOfCrests = 0.45;  // sqrt(2) / pi of the root mean square
    double missed = 0, standing = 0, outside = 0;
    for (const Patch& patch : explained_.patches()) {
      for (size_t i : patch.vertices) {
        const double d = patch.sheet.At_m(dvec3(in_.reference.mesh->position_m[i]));
        const double area = (*in_.reference.areas_m2)[i];
        // Of a wave, the mean of what stands over its middle.
        missed += area * (std::max(0.0, -d) + kMeanOfCrests * patch.sheet.waves_m);
        standing += area * std::max(0.0, -d - TaskVolumes::kStanding_m);
        // Whole voxels are within the leeway or not.
        if (d > in_.leeway_m) outside += area * (d - in_.leeway_m + voxel_m);
      }
    }
    const TaskVolumes& t = m_.task;
    if (const double task = t.task_m3(); task > 0) {
      const double done = 100 * t.done_m3() / task;
      Add(kDone, done, std::min(100.0, done + 100 * missed / task), kLeast_percent,
          {most_left_, kCloseness});
    }
    const double left = Sum_m3(t.standing) * kMm3;
    const double beyond =
        (Sum_m3(t.outside) - t.outside[static_cast<size_t>(cutting::Tissue::kNeighbour)]) * kMm3;
    Add("left_standing_mm3", left, std::max(0.0, left - standing * kMm3), kLeast_mm3,
        {most_left_, kCloseness, kDone});
    Add("outside_removed_mm3", beyond, std::max(0.0, beyond - outside * kMm3), kLeast_mm3,
        {most_over_, kCloseness, kSound});
  }

  // A floor that is too deep is nearer to the pulp.
  void Cover() {
    const WallFigures& floor = walls_[kFloor];
    if (!Made(floor) || !(floor.offset_m > 0)) return;
    Add("remaining_dentin_mm", m_.remaining_dentin_m * kMm,
        (m_.remaining_dentin_m + floor.offset_m) * kMm, kLeast_mm, {kOffsets[kFloor]});
  }

  const Measured& m_;
  const CauseInputs& in_;
  const Walls walls_;
  const Explained explained_;
  std::string_view most_over_, most_left_;
  std::vector<Charge> out_;
};

}  // namespace

std::vector<Charge> FindCharges(const Measured& measured, const CauseInputs& inputs) {
  return Charges(measured, inputs).Find();
}

}  // namespace enamel::scoring
