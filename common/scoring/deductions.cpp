#include "common/scoring/deductions.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

namespace enamel::scoring {
namespace {

using cutting::kBrickSide;
using cutting::Tissue;
using cutting::Volume;

// Less than this share of a voxel is what two cutters may differ by in rounding.
constexpr int32_t kMinFraction = 655;
// A fault begins where a stroke took enough of it to count: most strokes graze the tissue beyond by
// a micrometre. A share of the largest stroke's volume, and at most this much of tissue that must
// not be touched.
constexpr double kCountsOfLargest = 0.1, kCountsOfUntouchable_m3 = 5e-12;
// The resolution of moments.
constexpr double kBin_s = 0.25;

// A voxel that differs from the acceptable cut.
struct Fault {
  dvec3 at_m{0};
  double volume_m3 = 0;
  std::optional<uint32_t> tick;
};

// Gathers one deduction, brick by brick.
class Gatherer {
 public:
  // `untouchable`: healthy or not, nothing of it is to be taken: its first touch is where it began, wherever it is.
  Gatherer(uint32_t mistake, bool left, bool untouchable, const std::vector<Stroke>& strokes,
           uint64_t bin_ticks)
      : mistake_(mistake),
        left_(left),
        untouchable_(untouchable),
        strokes_(strokes),
        bin_ticks_(bin_ticks) {}

  void Take(const Fault& f) {
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
  Deduction Finish(const Volume& attempt, const StrokeRecorder& times) const {
    Deduction out;
    out.mistake = mistake_;
    out.left = left_;
    out.volume_m3 = volume_m3_;
    out.position_m = place_m_;
    const cutting::GridSpec& grid = attempt.spec();
    const dvec3 slope = attempt.SlopeAtSample((out.position_m - grid.origin_m()) / grid.voxel_m());
    const double length = std::sqrt(Dot(slope, slope));
    // Flat where the distance saturates: then from above.
    if (length > 0.1) out.facing = slope / length;
    out.here = !untouchable_;
    AddStrokes(out, times);
    return out;
  }

 private:
  const uint32_t mistake_;
  const bool left_, untouchable_;
  const std::vector<Stroke>& strokes_;
  const uint64_t bin_ticks_;
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
    if (untouchable_) counts_m3 = std::min(counts_m3, kCountsOfUntouchable_m3);
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

// Every voxel in which attempt and acceptable cut differ, brick by brick.
class FaultWalk {
 public:
  FaultWalk(const DeductionInputs& in, std::vector<Gatherer>& gatherers)
      : in_(in), r_(*in.r), gatherers_(gatherers), strokes_(in.strokes->Strokes()) {
    const auto bin = std::max<uint64_t>(1, std::llround(kBin_s * in.strokes->rate_hz()));
    for (size_t i = 0; i < in.found->mistakes.size(); ++i) {
      const MistakeKind kind = in.found->mistakes[i].kind;
      const bool untouchable = kind == MistakeKind::kNeighbour || kind == MistakeKind::kPulp;
      for (const bool left : {false, true}) {
        gatherers_.emplace_back(static_cast<uint32_t>(i), left, untouchable, strokes_, bin);
      }
      if (whole_.count(kind) == 0) whole_[kind] = static_cast<int>(i);
    }
    for (size_t t = 0; r_.contact() && t < r_.contact()->thirds().size(); ++t) {
      const auto& all = in.found->mistakes;
      const auto found = std::ranges::find(all, r_.contact()->thirds()[t].name, &Mistake::place);
      of_third_.push_back(found == all.end() ? -1 : static_cast<int>(found - all.begin()));
    }
  }

  void Run() {
    const cutting::Volume &initial = r_.initial(), &wanted = r_.prepared();
    for (int b = 0; b < initial.spec().brick_count(); ++b) {
      // Uniform in both: untouched by both, or air from the start.
      if (!in_.attempt->IsStored(b) && !wanted.IsStored(b)) continue;
      Brick(b);
      for (Gatherer& g : gatherers_) g.EndBrick();
    }
  }

 private:
  void Brick(int b) {
    const cutting::Volume &initial = r_.initial(), &prepared = r_.prepared();
    const cutting::GridSpec& grid = initial.spec();
    const ivec3 corner = ivec3(b % grid.bricks.x, b / grid.bricks.x % grid.bricks.y,
                               b / grid.bricks.x / grid.bricks.y) *
                         kBrickSide;
    const double voxel_m3 = grid.voxel_m() * grid.voxel_m() * grid.voxel_m() / 65536.0;
    std::optional<AcceptableCut::Brick> near;
    for (int i = 0; i < cutting::kBrickVoxels; ++i) {
      const ivec3 v = corner + ivec3(i % 8, i / 8 % 8, i / 64);
      const int phi = in_.attempt->PhiAt(v), wanted = prepared.PhiAt(v);
      const int32_t before = cutting::SolidFraction(initial.PhiAt(v));
      const int32_t more = std::min(before, cutting::SolidFraction(phi)) -
                           std::min(before, cutting::SolidFraction(wanted));
      if (more > -kMinFraction && more < kMinFraction) continue;
      const bool left = more > 0;
      if (!near) near.emplace(r_, b, kDeepest_m);
      const int mistake = MistakeAt(b, i, v, left, *near);
      if (mistake < 0) continue;
      Fault fault;
      // Where R took the centre too, the centre's moment is that of what was asked for and not of what went beyond it.
      if (!left && wanted < 0) fault.tick = in_.provenance->TickOf(v);
      fault.volume_m3 = std::abs(more) * voxel_m3;
      fault.at_m = grid.origin_m() + dvec3(v) * grid.voxel_m();
      gatherers_[2 * static_cast<size_t>(mistake) + (left ? 1 : 0)].Take(fault);
    }
  }

  int MistakeAt(int b, int i, const ivec3& v, bool left, AcceptableCut::Brick& near) const {
    const Tissue tissue = r_.initial().TissueAt(v);
    if (!left && tissue == Tissue::kNeighbour) return Whole(MistakeKind::kNeighbour);
    if (!left && tissue == Tissue::kPulp && Whole(MistakeKind::kPulp) >= 0)
      return Whole(MistakeKind::kPulp);
    if (left && tissue == Tissue::kCaries && Whole(MistakeKind::kCaries) >= 0)
      return Whole(MistakeKind::kCaries);
    if (const auto third = left && r_.contact() ? r_.contact()->ThirdAt(b, i) : std::nullopt)
      return of_third_[*third];
    const auto at = near.At(i);
    if (!at || (!left && at->distance_m > kElsewhereTo_m)) return Whole(MistakeKind::kHole);
    const int by_piece = (left ? in_.found->left : in_.found->over)[at->piece()];
    if (by_piece >= 0) return by_piece;
    return left ? Whole(MistakeKind::kNotDone) : Whole(MistakeKind::kHole);
  }
  int Whole(MistakeKind kind) const {
    const auto found = whole_.find(kind);
    return found == whole_.end() ? -1 : found->second;
  }

  const DeductionInputs& in_;
  const AcceptableCut& r_;
  std::vector<Gatherer>& gatherers_;
  std::vector<Stroke> strokes_;
  std::map<MistakeKind, int> whole_;  // the first mistake of each kind
  std::vector<int> of_third_;         // of the contact; -1: not lost
};

}  // namespace

std::vector<Deduction> FindDeductions(const DeductionInputs& inputs) {
  ENAMEL_CHECK(inputs.r && inputs.attempt && inputs.found && inputs.provenance && inputs.strokes);
  if (inputs.found->mistakes.empty()) return {};
  std::vector<Gatherer> gatherers;
  FaultWalk walk(inputs, gatherers);
  walk.Run();
  std::vector<Deduction> out;
  for (const Gatherer& g : gatherers) {
    if (!g.empty()) out.push_back(g.Finish(*inputs.attempt, *inputs.strokes));
  }
  return out;
}

}  // namespace enamel::scoring
