#include "common/scoring/deductions.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <string_view>
#include <utility>

#include "common/scoring/deviation.h"
#include "common/scoring/task.h"
#include "common/scoring/zones.h"

namespace enamel::scoring {
namespace {

using cutting::kBrickSide;
using cutting::Tissue;
using cutting::Volume;

// Less than this share of a voxel is what two cutters may differ by in rounding.
constexpr int32_t kLeastFraction = 655;
// Farther than this beyond the target's box a place belongs to no wall: a bur's width.
constexpr double kWallReach_m = 1e-3;

// A fault begins where a stroke took enough of it to count: most strokes graze the tissue beyond by
// a micrometre. A share of the largest stroke's volume, and at most this much of tissue that must
// not be touched.
constexpr double kCountsOfLargest = 0.1, kCountsOfUntouchable_m3 = 5e-12;
// The resolution of moments.
constexpr double kBin_s = 0.25;

constexpr uint32_t Bit(Part part) { return 1u << part; }
constexpr uint32_t Bit(Tissue tissue) { return 1u << static_cast<uint32_t>(tissue); }
constexpr uint32_t kAll = ~0u;
constexpr uint32_t kWalls = Bit(kMesial) | Bit(kDistal) | Bit(kBuccal) | Bit(kLingual);
constexpr uint32_t kSound = Bit(Tissue::kEnamel) | Bit(Tissue::kDentin);

enum Side : uint8_t { kOver = 1, kLeft = 2, kBoth = 3 };
// kStanding, of tissue left: farther from the reference's cut than a wall is short.
enum class Where : uint8_t { kAnywhere, kNear, kElsewhere, kStanding };

// The faults that a metric is about.
struct Subject {
  std::string_view metric;
  Side side = kBoth;
  uint32_t parts = kAll;  // kAll: of no part too
  uint32_t tissues = kAll;
  Where where = Where::kAnywhere;
};

constexpr Subject kSubjects[] = {
    {"wall_mesial_mm", kBoth, Bit(kMesial)},
    {"wall_distal_mm", kBoth, Bit(kDistal)},
    {"wall_buccal_mm", kBoth, Bit(kBuccal)},
    {"wall_lingual_mm", kBoth, Bit(kLingual)},
    {"floor_mm", kBoth, Bit(kFloor)},
    {"tilt_mesial_deg", kBoth, Bit(kMesial)},
    {"tilt_distal_deg", kBoth, Bit(kDistal)},
    {"tilt_buccal_deg", kBoth, Bit(kBuccal)},
    {"tilt_lingual_deg", kBoth, Bit(kLingual)},
    {"tilt_floor_deg", kBoth, Bit(kFloor)},
    {"wall_tilt_deg", kBoth, kWalls},
    {"undercut_deg", kOver, kWalls},
    {"wall_waviness_mm", kBoth, kWalls},
    {"floor_waviness_mm", kBoth, Bit(kFloor)},
    {"outline_over_mm", kOver, kWalls},
    {"outline_short_mm", kLeft, kWalls},
    {"deviation_rms_mm"},
    {"deviation_p95_mm"},
    {"within_100um_percent"},
    {"within_200um_percent"},
    {"within_300um_percent"},
    {"within_500um_percent"},
    {"overlap_percent"},
    {"most_left_mm", kLeft},
    {"task_done_percent", kLeft},
    {"missed_mm3", kLeft},
    {"left_standing_mm3", kLeft, kAll, kAll, Where::kStanding},
    {"zone_target_removed_percent", kLeft},
    {"caries_left_mm3", kLeft, kAll, Bit(Tissue::kCaries)},
    {"caries_left_percent", kLeft, kAll, Bit(Tissue::kCaries)},
    {"deepest_over_mm", kOver},
    {"zone_leeway_removed_percent", kOver},
    {"zone_container_removed_mm3", kOver},
    {"overcut_mm3", kOver, kAll, kAll, Where::kNear},
    {"outside_removed_mm3", kOver, kAll, ~Bit(Tissue::kNeighbour), Where::kElsewhere},
    {"damage_percent", kOver, kAll, kAll, Where::kElsewhere},
    {"neighbour_removed_mm3", kOver, kAll, Bit(Tissue::kNeighbour)},
    {"neighbour_depth_mm", kOver, kAll, Bit(Tissue::kNeighbour)},
    {"sound_removed_mm3", kOver, kAll, kSound},
    {"removed_enamel_mm3", kOver, kAll, Bit(Tissue::kEnamel)},
    {"removed_dentin_mm3", kOver, kAll, Bit(Tissue::kDentin)},
    {"removed_pulp_mm3", kOver, kAll, Bit(Tissue::kPulp)},
    {"pulp_exposed_mm2", kOver, kAll, Bit(Tissue::kPulp)},
    {"remaining_dentin_mm", kOver, Bit(kFloor)},
};

const Subject* FindSubject(std::string_view metric) {
  for (const Subject& s : kSubjects) {
    if (s.metric == metric) return &s;
  }
  return nullptr;
}

// A voxel that differs from the reference.
struct Fault {
  dvec3 at_m{0};
  double volume_m3 = 0;
  bool left = false;
  Tissue tissue = Tissue::kAir;
  Part part = kNoPart;
  // Within the leeway of the reference's cut, and farther than TaskVolumes::kStanding_m: computed
  // on demand.
  std::optional<bool> near, standing;
  std::optional<uint32_t> tick;
};

// The face of the target's box that a point is farthest beyond, or, inside, nearest to.
Part PartNear(const OpenBox& box, const dvec3& p) {
  std::array<double, kPartCount> beyond = {p.x - box.hi_m.x, box.lo_m.x - p.x, p.y - box.hi_m.y,
                                           box.lo_m.y - p.y, box.lo_m.z - p.z};
  if (box.mesial_x < 0) std::swap(beyond[kMesial], beyond[kDistal]);
  auto most = std::max_element(beyond.begin(), beyond.end());
  return *most > kWallReach_m ? kNoPart : static_cast<Part>(most - beyond.begin());
}

// Gathers one deduction, brick by brick.
class Gatherer {
 public:
  Gatherer(const Subject& subject, bool left, const std::vector<Stroke>& strokes,
           uint64_t bin_ticks, const WorstPlace* place = nullptr)
      : subject_(subject), left_(left), strokes_(strokes), bin_ticks_(bin_ticks), own_(place) {}

  bool AsksNear() const {
    return subject_.where == Where::kNear || subject_.where == Where::kElsewhere;
  }
  bool AsksStanding() const { return subject_.where == Where::kStanding; }
  // Healthy or not, nothing of it is to be taken: its first touch is where it began, wherever it
  // is.
  bool MustNotBeTouched() const {
    return subject_.tissues == Bit(Tissue::kNeighbour) || subject_.tissues == Bit(Tissue::kPulp);
  }
  // Whether it may be about a fault, near or elsewhere.
  bool May(const Fault& f) const {
    if (own_ != nullptr) {
      const dvec3 d = f.at_m - own_->at_m;
      if (Dot(d, d) > kNearPlace_m * kNearPlace_m) return false;
    }
    return f.left == left_ && (subject_.tissues & Bit(f.tissue)) != 0 &&
           (subject_.parts == kAll || (f.part != kNoPart && (subject_.parts & Bit(f.part)) != 0));
  }
  void Take(const Fault& f) {
    if (AsksNear() && (!f.near || *f.near != (subject_.where == Where::kNear))) return;
    if (AsksStanding() && !f.standing.value_or(false)) return;
    volume_m3_ += f.volume_m3;
    here_m3_ += f.volume_m3;
    moment_ += f.at_m * f.volume_m3;
    if (!f.tick) return;
    const uint32_t number = StrokeRecorder::NumberAt(strokes_, *f.tick);
    if (number == 0) return;
    StrokePart& part =
        parts_here_.try_emplace({number, *f.tick / bin_ticks_}, StrokePart{}).first->second;
    part.first_tick = std::min<uint64_t>(part.first_tick, *f.tick);
    part.volume_m3 += f.volume_m3;
  }
  void EndBrick() {
    if (here_m3_ > 0) {
      const dvec3 middle_m = moment_ / here_m3_;
      for (auto& [when, part] : parts_here_) {
        part.number = when.first;
        part.at_m = middle_m;
        parts_.push_back(part);
      }
      if (here_m3_ > most_m3_) {
        most_m3_ = here_m3_;
        place_m_ = middle_m;
      }
    }
    parts_here_.clear();
    here_m3_ = 0;
    moment_ = dvec3(0);
  }

  bool empty() const { return !(volume_m3_ > 0); }
  // This gathers too much taken, and the other too much left at the same place.
  bool IsPairOf(const Gatherer& left) const {
    return own_ != nullptr && own_ == left.own_ && !left_ && left.left_;
  }
  Deduction Finish(const Volume& attempt, const StrokeRecorder& times) const {
    Deduction out;
    out.criterion = std::string(subject_.metric);
    out.left = left_;
    out.volume_m3 = volume_m3_;
    out.position_m = place_m_;
    if (own_ != nullptr) out.position_m = own_->at_m;
    const cutting::GridSpec& grid = attempt.spec();
    const dvec3 slope = attempt.SlopeAtSample((out.position_m - grid.origin_m()) / grid.voxel_m());
    const double length = std::sqrt(Dot(slope, slope));
    // Flat where the distance saturates: then from above.
    if (length > 0.1) out.facing = slope / length;
    if (own_ != nullptr && own_->facing) out.facing = *own_->facing;
    out.here = !MustNotBeTouched();
    AddStrokes(out, times);
    return out;
  }

 private:
  const Subject& subject_;
  const bool left_;
  const std::vector<Stroke>& strokes_;
  const uint64_t bin_ticks_;
  const WorstPlace* own_;
  // The part of a stroke within kBin_s and within a brick.
  struct StrokePart {
    uint32_t number = 0;
    uint64_t first_tick = UINT64_MAX;
    double volume_m3 = 0;
    dvec3 at_m{0};  // the middle of the brick's fault
  };

  void AddStrokes(Deduction& out, const StrokeRecorder& times) const {
    std::map<uint32_t, FaultStroke> of_stroke;
    std::map<uint64_t, double> by_tick;
    double all_m3 = 0;
    for (const StrokePart& part : parts_) {
      const dvec3 d = part.at_m - out.position_m;
      if (out.here && Dot(d, d) > kNearPlace_m * kNearPlace_m) continue;
      FaultStroke& stroke =
          of_stroke.try_emplace(part.number, FaultStroke{part.number, part.first_tick})
              .first->second;
      stroke.first_tick = std::min(stroke.first_tick, part.first_tick);
      stroke.volume_m3 += part.volume_m3;
      by_tick[part.first_tick] += part.volume_m3;
      all_m3 += part.volume_m3;
    }
    if (of_stroke.empty()) return;
    for (const auto& [number, stroke] : of_stroke) out.strokes.push_back(stroke);
    out.stroke_count = static_cast<uint32_t>(out.strokes.size());
    double counts_m3 = 0;
    for (const FaultStroke& stroke : out.strokes)
      counts_m3 = std::max(counts_m3, kCountsOfLargest * stroke.volume_m3);
    if (MustNotBeTouched()) counts_m3 = std::min(counts_m3, kCountsOfUntouchable_m3);
    // By number, so by time.
    const auto first = std::find_if(out.strokes.begin(), out.strokes.end(),
                                    [&](const FaultStroke& s) { return s.volume_m3 >= counts_m3; });
    out.first_tick = first->first_tick;
    out.first_s = times.TimeOf_s(out.first_tick);
    double gone_m3 = 0;
    for (const auto& [tick, volume_m3] : by_tick) {
      gone_m3 += volume_m3;
      out.half_tick = tick;
      if (gone_m3 >= 0.5 * all_m3) break;
    }
    out.half_s = times.TimeOf_s(out.half_tick);
    std::stable_sort(
        out.strokes.begin(), out.strokes.end(),
        [](const FaultStroke& a, const FaultStroke& b) { return a.volume_m3 > b.volume_m3; });
    if (out.strokes.size() > Deduction::kMaxStrokes) out.strokes.resize(Deduction::kMaxStrokes);
    for (FaultStroke& stroke : out.strokes) {
      const Stroke& whole = strokes_[stroke.number - 1];
      stroke.first_s = times.TimeOf_s(stroke.first_tick);
      stroke.lasts_s = whole.last_s - whole.first_s;
    }
    out.strokes_m3 = all_m3;
  }

  double volume_m3_ = 0, here_m3_ = 0, most_m3_ = 0;
  dvec3 moment_{0}, place_m_{0};
  std::map<std::pair<uint32_t, uint64_t>, StrokePart>
      parts_here_;  // of this brick, by stroke and time
  std::vector<StrokePart> parts_;
};

// Every voxel in which attempt and reference differ, brick by brick.
class FaultWalk {
 public:
  FaultWalk(const DeductionInputs& in, const OpenBox& target, std::vector<Gatherer>& gatherers)
      : in_(in), target_(target), gatherers_(gatherers) {}

  void Run() {
    const auto bricks = static_cast<int>(in_.initial->spec().brick_count());
    for (int b = 0; b < bricks; ++b) {
      // Uniform in both: untouched by both, or air from the start.
      if (!in_.attempt->IsStored(b) && !in_.reference->IsStored(b)) continue;
      Brick(b);
      for (Gatherer& g : gatherers_) g.EndBrick();
    }
  }

 private:
  void Brick(int b) {
    const cutting::GridSpec& grid = in_.initial->spec();
    const ivec3 corner = ivec3(b % grid.bricks.x, b / grid.bricks.x % grid.bricks.y,
                               b / grid.bricks.x / grid.bricks.y) *
                         kBrickSide;
    const double voxel_m3 = grid.voxel_m() * grid.voxel_m() * grid.voxel_m() / 65536.0;
    for (int i = 0; i < cutting::kBrickVoxels; ++i) {
      const ivec3 v = corner + ivec3(i % 8, i / 8 % 8, i / 64);
      const int phi = in_.attempt->PhiAt(v), wanted = in_.reference->PhiAt(v);
      const int32_t more = cutting::SolidFraction(phi) - cutting::SolidFraction(wanted);
      if (more > -kLeastFraction && more < kLeastFraction) continue;
      Fault fault;
      fault.left = more > 0;
      // Where the reference took the centre too, the centre's moment is that of what was asked for
      // and not of what went beyond it.
      if (!fault.left && wanted < 0) fault.tick = in_.provenance->TickOf(v);
      fault.volume_m3 = std::abs(more) * voxel_m3;
      fault.at_m = grid.origin_m() + dvec3(v) * grid.voxel_m();
      fault.tissue = in_.initial->TissueAt(v);
      fault.part = PartNear(target_, fault.at_m);
      Share(fault);
    }
  }

  void Share(Fault& fault) {
    for (Gatherer& g : gatherers_) {
      if (!g.May(fault)) continue;
      if (g.AsksNear() && !fault.near) fault.near = IsWithin(fault.at_m, in_.near_m);
      if (g.AsksStanding() && !fault.standing)
        fault.standing = !IsWithin(fault.at_m, TaskVolumes::kStanding_m);
      g.Take(fault);
    }
  }

  bool IsWithin(const dvec3& at_m, double distance_m) {
    if (!in_.reference_cut || in_.reference_cut->position_m.empty()) return false;
    if (!cut_) cut_.emplace(*in_.reference_cut);
    return cut_->IsWithin(at_m, distance_m);
  }

  const DeductionInputs& in_;
  const OpenBox& target_;
  std::vector<Gatherer>& gatherers_;
  std::optional<surface::DistanceQuery> cut_;
};

}  // namespace

std::vector<Deduction> FindDeductions(const scene::Scene& scene, const scene::CavityTarget& target,
                                      const std::vector<std::string>& criteria,
                                      const DeductionInputs& inputs) {
  ENAMEL_CHECK(inputs.initial && inputs.attempt && inputs.reference && inputs.provenance &&
               inputs.strokes);
  auto boxes = BoxesOf(scene, target);
  const std::vector<Stroke> strokes = inputs.strokes->Strokes();
  const auto bin = std::max<uint64_t>(1, std::llround(kBin_s * inputs.strokes->rate_hz()));
  auto place_of = [&](std::string_view metric) -> const WorstPlace* {
    if (!inputs.places) return nullptr;
    for (const WorstPlace& p : *inputs.places) {
      if (p.name == metric) return &p;
    }
    return nullptr;
  };
  std::vector<Gatherer> gatherers;
  std::vector<Subject> placed;
  placed.reserve(criteria.size());  // gatherers keep them
  for (const std::string& criterion : criteria) {
    if (const WorstPlace* place = place_of(criterion); place && boxes.ok()) {
      const Subject& subject = placed.emplace_back(Subject{place->name});
      gatherers.emplace_back(subject, false, strokes, bin, place);
      gatherers.emplace_back(subject, true, strokes, bin, place);
      continue;
    }
    const Subject* subject = FindSubject(criterion);
    if (!subject || !boxes.ok()) continue;
    if ((subject->side & kOver) != 0) gatherers.emplace_back(*subject, false, strokes, bin);
    if ((subject->side & kLeft) != 0) gatherers.emplace_back(*subject, true, strokes, bin);
  }
  if (gatherers.empty()) return {};
  FaultWalk(inputs, boxes->target, gatherers).Run();
  std::vector<Deduction> out;
  for (size_t i = 0; i < gatherers.size(); ++i) {
    const Gatherer& g = gatherers[i];
    // Where both deductions of a place are empty, the one for too much taken is kept.
    const bool bare =
        i + 1 < gatherers.size() && g.IsPairOf(gatherers[i + 1]) && gatherers[i + 1].empty();
    if (!g.empty() || bare) out.push_back(g.Finish(*inputs.attempt, *inputs.strokes));
  }
  return out;
}

}  // namespace enamel::scoring
