#include "common/scoring/deductions.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <string_view>

#include "common/scoring/deviation.h"
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

// Of the stroke that took most.
constexpr double kCountsOfLargest = 0.1;

constexpr uint32_t Bit(Part part) { return 1u << part; }
constexpr uint32_t Bit(Tissue tissue) { return 1u << static_cast<uint32_t>(tissue); }
constexpr uint32_t kAll = ~0u;
constexpr uint32_t kWalls = Bit(kMesial) | Bit(kDistal) | Bit(kBuccal) | Bit(kLingual);
constexpr uint32_t kSound = Bit(Tissue::kEnamel) | Bit(Tissue::kDentin);

enum Side : uint8_t { kOver = 1, kLeft = 2, kBoth = 3 };
enum class Where : uint8_t { kAnywhere, kNear, kElsewhere };

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
  std::optional<bool> near;  // where somebody asks
  std::optional<uint32_t> tick;
};

// The face of the target's box that a point is farthest beyond, or, inside, nearest to.
Part PartNear(const OpenBox& box, const dvec3& p) {
  const std::array<double, kPartCount> beyond = {
      p.x - box.hi_m.x, box.lo_m.x - p.x, p.y - box.hi_m.y, box.lo_m.y - p.y, box.lo_m.z - p.z};
  auto most = std::max_element(beyond.begin(), beyond.end());
  return *most > kWallReach_m ? kNoPart : static_cast<Part>(most - beyond.begin());
}

// Gathers one deduction, brick by brick.
class Gatherer {
 public:
  Gatherer(const Subject& subject, bool left, const std::vector<Stroke>& strokes,
           const WorstPlace* place = nullptr)
      : subject_(subject), left_(left), strokes_(strokes), own_(place) {}

  bool AsksWhere() const { return subject_.where != Where::kAnywhere; }
  // Whether it may be about a fault, where near and elsewhere are not told apart.
  bool May(const Fault& f) const {
    if (own_ != nullptr) {
      const dvec3 d = f.at_m - own_->at_m;
      if (Dot(d, d) > kNearPlace_m * kNearPlace_m) return false;
    }
    return f.left == left_ && (subject_.tissues & Bit(f.tissue)) != 0 &&
           (subject_.parts == kAll || (f.part != kNoPart && (subject_.parts & Bit(f.part)) != 0));
  }
  void Take(const Fault& f) {
    if (AsksWhere() && (!f.near || *f.near != (subject_.where == Where::kNear))) return;
    volume_m3_ += f.volume_m3;
    here_m3_ += f.volume_m3;
    moment_ += f.at_m * f.volume_m3;
    if (!f.tick) return;
    const uint32_t number = StrokeRecorder::NumberAt(strokes_, *f.tick);
    if (number == 0) return;
    FaultStroke& stroke =
        of_stroke_.try_emplace(number, FaultStroke{number, *f.tick}).first->second;
    stroke.first_tick = std::min<uint64_t>(stroke.first_tick, *f.tick);
    stroke.volume_m3 += f.volume_m3;
  }
  void EndBrick() {
    if (here_m3_ > most_m3_) {
      most_m3_ = here_m3_;
      place_m_ = moment_ / here_m3_;
    }
    here_m3_ = 0;
    moment_ = dvec3(0);
  }

  bool empty() const { return !(volume_m3_ > 0); }
  // This is of what was taken, and the other of what was left at the same place.
  bool IsPairOf(const Gatherer& left) const {
    return own_ != nullptr && own_ == left.own_ && !left_ && left.left_;
  }
  Deduction Finish(const Volume& attempt, const StrokeRecorder& times) const {
    Deduction out;
    out.criterion = std::string(subject_.metric);
    out.left = left_;
    out.volume_m3 = volume_m3_;
    out.position_m = place_m_;
    const cutting::GridSpec& grid = attempt.spec();
    const dvec3 slope = attempt.SlopeAtSample((place_m_ - grid.origin_m()) / grid.voxel_m());
    const double length = std::sqrt(Dot(slope, slope));
    // Flat where the distance saturates: then from above, as a tooth is looked at.
    if (length > 0.1) out.facing = slope / length;
    if (own_ != nullptr) out.position_m = own_->at_m, out.facing = own_->facing;
    if (of_stroke_.empty()) return out;
    for (const auto& [number, stroke] : of_stroke_) out.strokes.push_back(stroke);
    out.stroke_count = static_cast<uint32_t>(out.strokes.size());
    double largest_m3 = 0;
    for (const FaultStroke& stroke : out.strokes)
      largest_m3 = std::max(largest_m3, stroke.volume_m3);
    // By number, so by time. Most strokes graze what is beyond by a micrometre: where it began is where
    // one began that counts.
    const auto first = std::find_if(
        out.strokes.begin(), out.strokes.end(),
        [&](const FaultStroke& s) { return s.volume_m3 >= kCountsOfLargest * largest_m3; });
    out.first_tick = first->first_tick;
    out.first_s = times.TimeOf_s(out.first_tick);
    std::stable_sort(
        out.strokes.begin(), out.strokes.end(),
        [](const FaultStroke& a, const FaultStroke& b) { return a.volume_m3 > b.volume_m3; });
    if (out.strokes.size() > Deduction::kMaxStrokes) out.strokes.resize(Deduction::kMaxStrokes);
    for (FaultStroke& stroke : out.strokes) stroke.first_s = times.TimeOf_s(stroke.first_tick);
    return out;
  }

 private:
  const Subject& subject_;
  const bool left_;
  const std::vector<Stroke>& strokes_;
  const WorstPlace* own_;
  double volume_m3_ = 0, here_m3_ = 0, most_m3_ = 0;
  dvec3 moment_{0}, place_m_{0};
  std::map<uint32_t, FaultStroke> of_stroke_;
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
      if (g.AsksWhere() && !fault.near) fault.near = IsNear(fault.at_m);
      g.Take(fault);
    }
  }

  bool IsNear(const dvec3& at_m) {
    if (!in_.reference_cut || in_.reference_cut->position_m.empty()) return false;
    if (!cut_) cut_.emplace(*in_.reference_cut);
    return cut_->IsWithin(at_m, in_.near_m);
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
      gatherers.emplace_back(subject, false, strokes, place);
      gatherers.emplace_back(subject, true, strokes, place);
      continue;
    }
    const Subject* subject = FindSubject(criterion);
    if (!subject || !boxes.ok()) continue;
    if ((subject->side & kOver) != 0) gatherers.emplace_back(*subject, false, strokes);
    if ((subject->side & kLeft) != 0) gatherers.emplace_back(*subject, true, strokes);
  }
  if (gatherers.empty()) return {};
  FaultWalk(inputs, boxes->target, gatherers).Run();
  std::vector<Deduction> out;
  for (size_t i = 0; i < gatherers.size(); ++i) {
    const Gatherer& g = gatherers[i];
    // Of the two of a place, the one for what was taken is there where both are empty.
    const bool bare =
        i + 1 < gatherers.size() && g.IsPairOf(gatherers[i + 1]) && gatherers[i + 1].empty();
    if (!g.empty() || bare) out.push_back(g.Finish(*inputs.attempt, *inputs.strokes));
  }
  return out;
}

}  // namespace enamel::scoring
