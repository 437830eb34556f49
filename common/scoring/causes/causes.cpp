#include "common/scoring/causes/causes.h"

#include <algorithm>
#include <cmath>

#include "common/scoring/causes/explained.h"
#include "common/scoring/metrics.h"

namespace enamel::scoring {
namespace {

constexpr double kMm = 1e3, kMm3 = 1e9;
// Charges that differ by less are left at the value.
constexpr double kLeast_mm = 0.02, kLeast_deg = 0.5, kLeast_mm3 = 0.01, kLeast_percent = 0.2;

constexpr std::array<std::string_view, kPartCount> kOffsets = {
    "wall_mesial_mm", "wall_distal_mm", "wall_buccal_mm", "wall_lingual_mm", "floor_mm"};
constexpr std::string_view kCloseness = "deviation_rms_mm", kSound = "sound_removed_mm3",
                           kDone = "task_done_percent", kTop = "reduction_top_percent",
                           kLine = "finish_depth_mm", kAxis = "crown_axis_deg",
                           kCaries = "caries_left_percent", kOutside = "outside_removed_mm3",
                           kWallTilt = "wall_tilt_deg", kFloorTilt = "tilt_floor_deg",
                           kWallWaves = "wall_waviness_mm", kFloorWaves = "floor_waviness_mm";

constexpr int kUp = 4;  // Patch::facing

bool Made(const WallFigures& w) { return w.in_task && w.made; }

// A sum by patch, and whose is the most.
class Shares {
 public:
  explicit Shares(const Explained& explained) : explained_(explained) {
    of_.resize(explained.patches().size());
  }
  void Add(const Patch& patch, double amount) {
    of_[static_cast<size_t>(&patch - explained_.patches().data())] += amount;
    sum_ += amount;
  }
  double sum() const { return sum_; }
  const Patch& Most() const {
    const auto most = std::ranges::max_element(of_) - of_.begin();
    return explained_.patches()[static_cast<size_t>(most)];
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
        explained_(walls_, inputs) {
    for (const OutlineFigures::Over& o : m_.outline.over_at) {
      const bool scraped = o.by_m > Explained::kFarthest_m;
      scraped_ = scraped_ || scraped;
      const double by = scraped ? o.by_m : explained_.At(o.at_m, dvec3(0), o.by_m, false).by_m;
      outline_rest_.push_back({o.at_m, std::max(0.0, o.by_m - by)});
    }
    if (!measured.crown.in_task) return;
    double lo = 0, hi = 0;
    bool any = false;
    for (const Patch& patch : explained_.patches()) {
      if (patch.vertices.empty()) continue;
      lo = any ? std::min(lo, patch.middle_m.z) : patch.middle_m.z;
      hi = any ? std::max(hi, patch.middle_m.z) : patch.middle_m.z;
      any = true;
    }
    top_from_m_ = 0.5 * (lo + hi);
  }

  std::vector<Charge> Find() {
    Offsets();
    Turn();
    Tilts();
    Waves();
    Surfaces();
    Outline();
    Top();
    FinishLine();
    Volumes();
    Cover();
    return std::move(out_);
  }

 private:
  bool IsCharged(std::string_view name) const {
    return std::ranges::find(out_, name, &Charge::name) != out_.end();
  }
  void Add(std::string_view name, double value, double charged, double least,
           const std::vector<std::string_view>& under) {
    if (!(std::fabs(value - charged) > least)) return;
    Charge charge{name, charged, {}};
    auto put = [&](std::string_view metric) {
      const bool known = std::ranges::find(charge.under, metric) != charge.under.end();
      if (metric.empty() || metric == name || known || charge.under.size() == kMaxUnder) return;
      charge.under.push_back(metric);
    };
    for (std::string_view metric : under) {
      put(metric);
      // A wall that is short because the cut is shifted is charged under the opposite one.
      const auto short_of = std::ranges::find(out_, metric, &Charge::name);
      if (short_of == out_.end() || short_of->under.empty()) continue;
      if (std::ranges::count(kOffsets, short_of->under.front())) put(short_of->under.front());
    }
    if (!charge.under.empty()) out_.push_back(std::move(charge));
  }

  // A wall that leans about a line between its foot and its rim is off by its lean alone.
  static double OffsetOf_m(const Sheet& sheet) {
    const double foot = sheet.AtHeight_m(sheet.s_least_m), rim = sheet.AtHeight_m(sheet.s_most_m);
    if (foot * rim <= 0) return 0;
    return std::fabs(foot) < std::fabs(rim) ? foot : rim;
  }

  bool IsTop(const Patch& patch) const {
    return m_.crown.in_task && patch.facing == kUp && patch.middle_m.z > top_from_m_;
  }

  bool IsShoulder(const Patch& patch) const {
    return m_.crown.in_task && patch.facing == kUp && !IsTop(patch);
  }

  // Where a wall or floor, or a stump's top or shoulder, is itself measured; of another patch empty.
  std::string_view OffsetName(const Patch& patch) const {
    if (patch.part != kNoPart) return kOffsets[patch.part];
    if (IsShoulder(patch)) return kLine;
    return IsTop(patch) ? kTop : std::string_view();
  }
  // One side of a stump leans out as the other leans in: of the whole stump.
  bool LeansAsAWhole(int facing) const {
    double lean[2] = {0, 0};
    for (const Patch& patch : explained_.patches()) {
      if (patch.facing / 2 == facing / 2) {
        lean[patch.facing % 2] += patch.area_m2 * patch.sheet.plane.b;
      }
    }
    return lean[0] * lean[1] < 0;
  }
  // The same for what of it explains the most: where it lies, how it leans, or its waves.
  std::string_view CauseName(const Patch& patch) const {
    const Sheet& s = patch.sheet;
    if (patch.part == kNoPart && !(m_.crown.in_task && patch.upright())) return OffsetName(patch);
    const double lean = 0.5 * std::fabs(s.AtHeight_m(s.s_most_m) - s.AtHeight_m(s.s_least_m));
    const double waves = std::sqrt(2.0) * s.waves_m;
    const bool floor = patch.part == kFloor;
    if (std::max(lean, waves) < std::fabs(OffsetOf_m(s))) return OffsetName(patch);
    if (patch.part == kNoPart) {
      constexpr int kTowardsY = 2;  // Patch::facing
      if (lean < waves) return {};
      if (LeansAsAWhole(patch.facing)) return kAxis;
      return patch.facing < kTowardsY ? "convergence_mesiodistal_deg"
                                      : "convergence_buccolingual_deg";
    }
    if (lean > waves) return floor ? kFloorTilt : kWallTilt;
    return floor ? kFloorWaves : kWallWaves;
  }

  // Opposite walls that lie off the same way are one shift: charged where the cut went too far.
  void Offsets() {
    for (size_t p = 0; p < kFloor; ++p) {
      const double offset = walls_[p].offset_m, least = OffsetOf_m(walls_[p].over);
      if (Made(walls_[p]) && std::fabs(least) < std::fabs(offset))
        Add(kOffsets[p], offset * kMm, least * kMm, kLeast_mm,
            {walls_[p].tilt_deg < 0 && walls_[p].opens_deg < 0 ? "undercut_deg" : "", kWallTilt});
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
      if (!Made(w)) continue;
      const double tilt = std::fabs(w.tilt_deg);
      most = std::max(most, tilt);
      leans_in = std::max(leans_in, -w.opens_deg);
      // What leans over the cavity is undercut_deg's; the rest of its tilt is not.
      const double inwards = w.tilt_deg < 0 ? std::max(0.0, -w.opens_deg) : 0;
      rest = std::max(
          rest, w.tilt_deg < 0 ? tilt - std::min(tilt, inwards) : std::max(0.0, tilt - whole));
    }
    Add(kWallTilt, most, rest, kLeast_deg, {leans_in > 0 ? "undercut_deg" : ""});
    const WallFigures& floor = walls_[kFloor];
    if (Made(floor) && whole > 0) {
      Add(kFloorTilt, floor.tilt_deg, std::max(0.0, floor.tilt_deg - whole), kLeast_deg,
          {leans_in > 0 ? "undercut_deg" : "", kWallTilt});
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
    Add(kWallWaves, most * kMm, std::min(most, waves) * kMm, 0, {"deepest_over_mm", kCloseness});
    const WallFigures& floor = walls_[kFloor];
    if (Made(floor)) {
      Add(kFloorWaves, floor.waviness_m * kMm, std::min(floor.waviness_m, floor.over.waves_m) * kMm,
          0, {"deepest_over_mm", kCloseness});
    }
  }

  // Vertices of a cut that comes nowhere near the reference's: another hole. Parts of the attempt's
  // surface that lie too deep, by the triangles that join them.
  std::vector<bool> FindElsewhere() const {
    const surface::Mesh& made = *in_.attempt.mesh;
    const size_t n = made.position_m.size();
    std::vector<uint32_t> part(n);  // towards the first vertex of its part
    for (size_t i = 0; i < n; ++i) part[i] = static_cast<uint32_t>(i);
    auto first = [&](uint32_t i) {
      while (part[i] != i) i = part[i] = part[part[i]];
      return i;
    };
    auto deep = [&](uint32_t i) { return in_.attempt_m[i] > kLeast_mm / kMm; };
    for (const auto& corners : made.triangles) {
      for (size_t k = 0; k < 3; ++k) {
        const uint32_t a = corners[k], b = corners[(k + 1) % 3];
        if (!deep(a) || !deep(b)) continue;
        const uint32_t x = first(a), y = first(b);
        part[std::max(x, y)] = std::min(x, y);
      }
    }
    std::vector<bool> near(n), out(n);
    for (uint32_t i = 0; i < n; ++i) {
      if (!deep(i) || near[first(i)]) continue;
      near[first(i)] = in_.reference_cut.IsWithin(dvec3(made.position_m[i]), in_.leeway_m);
    }
    for (uint32_t i = 0; i < n; ++i) out[i] = deep(i) && !near[first(i)];
    return out;
  }

  // How much too wide the outline is near a place, beyond what patches explain.
  double OutlineOverNear_m(const dvec3& at) const {
    double most = 0;
    for (const OutlineFigures::Over& o : outline_rest_) {
      const dvec3 away = o.at_m - at;
      if (Dot(away, away) < Explained::kFarthest_m * Explained::kFarthest_m)
        most = std::max(most, o.by_m);
    }
    return most;
  }

  // The distances between the surfaces, less what walls and floor explain, a wide outline, or a hole
  // elsewhere.
  void Surfaces() {
    Shares over(explained_);
    std::vector<float> deeper = in_.attempt_m;
    const surface::Mesh& made = *in_.attempt.mesh;
    const std::vector<bool> elsewhere = FindElsewhere();
    double by_patches = 0, by_outline = 0, by_elsewhere = 0;
    // One place, and what explains most of the whole cut need not be near it. A patch without a
    // name is charged nowhere.
    const Patch* at_deepest = nullptr;
    double deepest_m = 0;
    for (size_t i = 0; i < deeper.size(); ++i) {
      if (!(deeper[i] > kLeast_mm / kMm)) continue;
      const dvec3 at(made.position_m[i]);
      double d = deeper[i];
      const double area = (*in_.attempt.areas_m2)[i];
      auto take = [&](double by, double& sum) {
        const double taken = std::min(by, d);
        d -= taken, sum += area * taken;
      };
      if (elsewhere[i]) {
        take(d, by_elsewhere);
      } else {
        const Explanation found = explained_.At(at, dvec3(made.normal[i]), d, false);
        if (d > deepest_m) deepest_m = d, at_deepest = found.wall ? found.wall : found.most;
        take(found.by_m, by_patches);
        if (d > kLeast_mm / kMm) take(OutlineOverNear_m(at), by_outline);
      }
      deeper[i] = static_cast<float>(d);
    }
    std::vector<float> rest = in_.reference_m;
    Shares left(explained_);
    const surface::Mesh& wanted = *in_.reference.mesh;
    for (size_t i = 0; i < rest.size(); ++i) {
      if (!(*in_.reference.cut)[i] || !(std::fabs(rest[i]) > kLeast_mm / kMm)) continue;
      const bool is_left = rest[i] > 0;
      const double d = std::fabs(rest[i]);
      const dvec3 at(wanted.position_m[i]);
      const Explanation found = explained_.At(at, dvec3(wanted.normal[i]), d, is_left);
      const double by = std::min(d, found.by_m), weight = (*in_.reference.areas_m2)[i];
      if (found.most != nullptr) {
        (is_left ? left : over).Add(*found.most, by * weight);
        TakeSquares(*found.most, at, d, weight);
      }
      rest[i] = static_cast<float>(is_left ? d - by : by - d);
    }
    const double deepest_mm = m_.deepest_over.depth_m * kMm;
    std::vector<std::string_view> under;
    if (by_elsewhere > std::max(by_patches, by_outline)) {
      under = {kOutside, kSound};
    } else if (by_outline > by_patches) {
      under = {"outline_over_mm"};
    } else {
      const Patch& there = at_deepest != nullptr ? *at_deepest : over.Most();
      under = {CauseName(there), OffsetName(there), kCloseness, kSound};
    }
    Add("deepest_over_mm", deepest_mm,
        std::min(deepest_mm, DeepestOver(in_.attempt, deeper).depth_m * kMm), kLeast_mm, under);
    const DeviationFigures spots = MeasureDeviation(in_.reference, rest);
    const double left_mm = m_.deviation.most_left_m * kMm, p95_mm = m_.deviation.p95_m * kMm;
    Add("most_left_mm", left_mm, std::min(left_mm, spots.most_left_m * kMm), kLeast_mm,
        {CauseName(left.Most()), OffsetName(left.Most()), kCloseness, kDone});
    const Patch& most = (over.sum() > left.sum() ? over : left).Most();
    Add("deviation_p95_mm", p95_mm, std::min(p95_mm, spots.p95_m * kMm), kLeast_mm,
        {kCloseness, CauseName(most), OffsetName(most)});
    Closeness();
    most_over_ = OffsetName(over.Most()), most_left_ = OffsetName(left.Most());
    cause_over_ = CauseName(over.Most()), cause_left_ = CauseName(left.Most());
  }

  // Of the squares of the distances, the part that a patch takes away whose lean, waves or top is
  // what another metric is about.
  void TakeSquares(const Patch& patch, const dvec3& point_m, double d, double weight) {
    const Sheet& sheet = patch.sheet;
    auto without = [&](double part) {
      const double rest = d - std::clamp(part, 0.0, d);
      return weight * (d * d - rest * rest);
    };
    const double height = std::fabs(sheet.At_m(point_m));
    if (IsTop(patch)) {
      squares_[kTopOff] += without(height);
      return;
    }
    if (IsShoulder(patch)) squares_[kShoulderOff] += without(height);
    // Along its length a wall lies off where the cut is turned: nothing but closeness is about that.
    const double lean = std::fabs(
        sheet.AtHeight_m(std::clamp(Dot(point_m, sheet.up), sheet.s_least_m, sheet.s_most_m)));
    squares_[patch.upright() ? kWallLean : kFloorLean] +=
        without((patch.upright() ? lean : height) - std::fabs(OffsetOf_m(sheet)));
    squares_[patch.upright() ? kWallWave : kFloorWave] += weight * sheet.waves_m * sheet.waves_m;
  }

  // Of the root mean square, which is the whole, only what other metrics are about is left out:
  // leaning walls, or waves, or a stump's top or shoulder, whichever is more.
  void Closeness() {
    double area = 0, all = 0;
    for (size_t i = 0; i < in_.reference_m.size(); ++i) {
      if (!(*in_.reference.cut)[i]) continue;
      const double weight = (*in_.reference.areas_m2)[i], d = in_.reference_m[i];
      area += weight, all += weight * d * d;
    }
    if (!(area > 0)) return;
    const auto most = std::ranges::max_element(squares_) - squares_.begin();
    const double rms_mm = std::sqrt(std::max(0.0, all - squares_[most]) / area) * kMm;
    const double value = m_.deviation.rms_m * kMm;
    using Names = std::vector<std::string_view>;
    const std::array<Names, kKinds> under = {
        Names{kWallTilt, "convergence_mesiodistal_deg", "convergence_buccolingual_deg", kAxis},
        {kFloorTilt},
        {kWallWaves},
        {kFloorWaves, "finish_waviness_mm"},
        {kTop},
        {kLine}};
    Add(kCloseness, value, std::min(value, rms_mm), kLeast_mm, under[most]);
  }

  // Over the columns of the reference's top a side that was cut too far takes height as well. The
  // top itself lies off by what three quarters of it do at least: its round edge lies off by less, and
  // of a thin edge half is gone where both sides are 0.3 mm too far in.
  void Top() {
    if (!m_.crown.in_task || !(m_.stump.top_asked_m > 0)) return;
    std::vector<WeightedValue> deeper;
    for (const Patch& patch : explained_.patches()) {
      if (!IsTop(patch)) continue;
      for (size_t i : patch.vertices)
        deeper.push_back({-double{in_.reference_m[i]}, (*in_.reference.areas_m2)[i]});
    }
    if (deeper.empty()) return;
    const double most_m = WeightedQuantile(deeper, 0.75), least_m = WeightedQuantile(deeper, 0.25);
    const double off_m = std::max(0.0, least_m) + std::min(0.0, most_m);
    const double value = 100 * m_.stump.top_done;
    const double charged = 100 * (1 + off_m / m_.stump.top_asked_m);
    if (std::fabs(charged - 100) < std::fabs(value - 100))
      Add(kTop, value, charged, kLeast_percent, {kCloseness});
  }

  // Where the wall leaves no room for a finish line, the line has no height.
  void FinishLine() {
    if (!m_.crown.in_task || !m_.crown.made) return;
    Add("finish_waviness_mm", m_.crown.waviness_m * kMm, m_.crown.waviness_made_m * kMm, kLeast_mm,
        {kCloseness});
  }

  void Outline() {
    if (!m_.outline.in_task || m_.outline.over_at.empty()) return;
    std::vector<WeightedValue> rest;
    for (const OutlineFigures::Over& o : outline_rest_) rest.push_back({o.by_m, 1});
    for (size_t i = rest.size(); i < m_.outline.points; ++i) rest.push_back({0, 1});
    const double value = m_.outline.over_m * kMm;
    Add("outline_over_mm", value, std::min(value, WeightedQuantile(std::move(rest), 0.95) * kMm),
        kLeast_mm, {scraped_ ? kOutside : "", cause_over_, most_over_, kCloseness});
  }

  // What a wall or floor that lies elsewhere leaves or takes.
  void Volumes() {
    const double voxel_m = in_.reference.volume->spec().voxel_m();
    constexpr double kMeanOfCrests = 0.45;  // sqrt(2) / pi of the root mean square
    double missed = 0, standing = 0, outside = 0;
    const double top_short_m = std::max(0.0, 1 - m_.stump.top_done) * m_.stump.top_asked_m;
    for (const Patch& patch : explained_.patches()) {
      for (size_t i : patch.vertices) {
        double d = patch.sheet.At_m(dvec3(in_.reference.mesh->position_m[i]));
        // Beside the walls nearest distances are less than how far a shoulder or a top lies off.
        if (IsShoulder(patch)) {
          d = m_.crown.depth_m > 0 ? std::max(d, m_.crown.depth_m) : std::min(d, m_.crown.depth_m);
        }
        if (IsTop(patch) && top_short_m > 0) d = std::min(d, -top_short_m);
        const double area = (*in_.reference.areas_m2)[i];
        // Of a wave, the mean of what stands over its middle.
        missed += area * (std::max(0.0, -d) + kMeanOfCrests * patch.sheet.waves_m);
        // Whole voxels are within such a distance or not.
        if (-d > TaskVolumes::kStanding_m)
          standing += area * (-d - TaskVolumes::kStanding_m + voxel_m);
        if (d > in_.leeway_m) outside += area * (d - in_.leeway_m + voxel_m);
      }
    }
    const TaskVolumes& t = m_.task;
    constexpr auto kLesion = static_cast<size_t>(cutting::Tissue::kCaries);
    if (const double task = t.task_m3(); task > 0) {
      const double done = 100 * t.done_m3() / task;
      Add(kDone, done, std::min(100.0, done + 100 * missed / task), kLeast_percent,
          {cause_left_, most_left_, kCloseness});
      // Caries that a wall or floor in the wrong place leaves. Elsewhere it counts.
      if (const double all_missed = Sum_m3(t.missed); all_missed > 0 && t.task[kLesion] > 0) {
        const double share = std::min(1.0, missed / all_missed);
        const double caries = 100 * t.missed[kLesion] / t.task[kLesion];
        Add(kCaries, caries, caries * (1 - share), kLeast_percent, {cause_left_, most_left_});
      }
    }
    const double left = Sum_m3(t.standing) * kMm3;
    const double beyond =
        (Sum_m3(t.outside) - t.outside[static_cast<size_t>(cutting::Tissue::kNeighbour)]) * kMm3;
    Add("left_standing_mm3", left, std::max(0.0, left - standing * kMm3), kLeast_mm3,
        {cause_left_, most_left_, kCloseness, t.task[kLesion] > 0 ? kCaries : kDone});
    Add(kOutside, beyond, std::max(0.0, beyond - outside * kMm3), kLeast_mm3,
        {cause_over_, most_over_, kCloseness, kSound});
    if (const double task_mm3 = t.task_m3() * kMm3; task_mm3 > 0) {
      const double damage = 100 * Sum_m3(t.outside) * kMm3 / task_mm3;
      Add("damage_percent", damage, std::max(0.0, damage - 100 * outside * kMm3 / task_mm3),
          kLeast_percent, {cause_over_, most_over_, kCloseness, kSound});
    }
  }

  // A floor or wall that is too deep is nearer to the pulp.
  void Cover() {
    const auto at = m_.remaining_dentin.vertex;
    if (!at || !(in_.attempt_m[*at] > 0)) return;
    const surface::Mesh& made = *in_.attempt.mesh;
    const double d = in_.attempt_m[*at];
    const Explanation found =
        explained_.At(dvec3(made.position_m[*at]), dvec3(made.normal[*at]), d, false);
    if (found.most == nullptr) return;
    const double cover_m = m_.remaining_dentin.least_m;
    Add("remaining_dentin_mm", cover_m * kMm, (cover_m + std::min(d, found.by_m)) * kMm, kLeast_mm,
        {CauseName(*found.most), OffsetName(*found.most), kCloseness, kSound});
  }

  const Measured& m_;
  const CauseInputs& in_;
  const Walls walls_;
  const Explained explained_;
  std::vector<OutlineFigures::Over> outline_rest_;  // less what patches explain
  // The outline is so wide that the surface around the cavity was scraped, and no wall moved.
  bool scraped_ = false;
  double top_from_m_ = 0;
  enum Kind { kWallLean, kFloorLean, kWallWave, kFloorWave, kTopOff, kShoulderOff, kKinds };
  std::array<double, kKinds> squares_{};  // of the distances, area-weighted, m^4
  std::string_view most_over_, most_left_, cause_over_, cause_left_;
  std::vector<Charge> out_;
};

}  // namespace

std::vector<Charge> FindCharges(const Measured& measured, const CauseInputs& inputs) {
  return Charges(measured, inputs).Find();
}

}  // namespace enamel::scoring
