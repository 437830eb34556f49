#include "station/lab/grades/sentences.h"

#include <algorithm>
#include <optional>

#include "common/scoring/brick_samples.h"

namespace enamel::station::lab {
namespace {

using cutting::Tissue;
using scoring::AcceptableCut;
using scoring::MistakeKind;

// What a kind claims of its place.
enum class Claim {
  kOver,
  kLeft,
  kEither,
  kElsewhere,
  kNeighbour,
  kPulp,
  kCaries,
  kContact,
  kNotDone
};
Claim ClaimOf(MistakeKind kind) {
  using enum MistakeKind;
  switch (kind) {
    case kOverExtended:
    case kDeep:
    case kOverReduced:
    case kGroove:
    case kPit:
      return Claim::kOver;
    case kUnderExtended:
    case kShallow:
    case kUnderReduced:
    case kLedge:
    case kOverhang:
    case kLip:
    case kCorner:
    case kBump:
    case kStanding:
      return Claim::kLeft;
    case kHole:
      return Claim::kElsewhere;
    case kNeighbour:
      return Claim::kNeighbour;
    case kPulp:
      return Claim::kPulp;
    case kCaries:
      return Claim::kCaries;
    case kContact:
      return Claim::kContact;
    case kNotDone:
      return Claim::kNotDone;
    case kShifted:
    case kTurned:
    case kTipped:
    case kLeansOut:
    case kLeansIn:
    case kSlopes:
    case kWave:
    case kUneven:
      break;
  }
  return Claim::kEither;
}

// mm^3 that the attempt lacks and holds against R.
struct Seen {
  double over = 0, left = 0;
};
struct SeenCut {
  std::vector<Seen> regions;  // beyond the leeway, each voxel at the nearest region
  double far_over = 0, neighbour = 0, pulp = 0, caries = 0, contact = 0, left = 0;
};

class Looker {
 public:
  Looker(const AcceptableCut& r, const cutting::Volume& attempt)
      : r_(r), attempt_(attempt), h_m_(r.initial().spec().voxel_m()) {
    out_.regions.resize(r.regions().size());
  }

  SeenCut Look() {
    for (int b = 0; b < r_.initial().spec().brick_count(); ++b) LookAt(b);
    return std::move(out_);
  }

 private:
  void LookAt(int b) {
    const scoring::BrickSamples before(r_.initial(), b), wanted(r_.prepared(), b),
        after(attempt_, b);
    std::optional<AcceptableCut::Brick> places;
    for (int i = 0; i < cutting::kBrickVoxels; ++i) {
      const double f0 = before.Solid(i) / kWhole, fr = wanted.Solid(i) / kWhole;
      const double off = (after.Solid(i) / kWhole - fr) * h_m_ * h_m_ * h_m_ * 1e9;
      if (f0 <= 0 || off == 0) continue;
      if (!places) places.emplace(r_, b, scoring::kDeepest_m);
      Add(*places, i, std::max(0.0, -off), std::max(0.0, off));
      if (r_.contact() && r_.contact()->RowAt(b, i)) out_.contact += std::max(0.0, off);
    }
  }

  void Add(AcceptableCut::Brick& places, int i, double over, double left) {
    const Tissue tissue = r_.initial().TissueAtPoint(places.PointOf(i));
    if (tissue == Tissue::kNeighbour) {
      out_.neighbour += over;
      return;
    }
    if (tissue == Tissue::kPulp) out_.pulp += over;
    if (tissue == Tissue::kCaries) out_.caries += left;
    out_.left += left;
    const auto at = places.At(i);
    if (!at || at->distance_m > scoring::kElsewhereFrom_m) out_.far_over += over;
    if (!at || at->distance_m + 0.5 * h_m_ <= scoring::kLeeway_m) return;
    // Where two surfaces meet, either may have moved.
    for (const uint32_t piece : {at->edge_share > 0 ? at->edge : at->next_to, at->next_to,
                                 at->beside_share > 0 ? at->beside : at->next_to}) {
      Seen& seen = out_.regions[r_.pieces()[piece].region];
      seen.over += over, seen.left += left;
    }
  }

  static constexpr double kWhole = 65536;
  const AcceptableCut& r_;
  const cutting::Volume& attempt_;
  const double h_m_;
  SeenCut out_;
};

class Checker {
 public:
  Checker(const AcceptableCut& r, const std::vector<scoring::RegionMeasure>& measures,
          const std::vector<scoring::RegionCost>& costs, SeenCut seen)
      : r_(r), measures_(measures), costs_(costs), seen_(std::move(seen)) {}

  // Empty: true.
  std::string WrongWith(const scoring::Mistake& m) const {
    switch (ClaimOf(m.kind)) {
      case Claim::kElsewhere:
        return Whole(scoring::whole::kElsewhere, seen_.far_over);
      case Claim::kNeighbour:
        return Whole(scoring::whole::kNeighbour, seen_.neighbour);
      case Claim::kPulp:
        return Whole(scoring::whole::kPulp, seen_.pulp);
      case Claim::kCaries:
        return Whole(scoring::whole::kCaries, seen_.caries);
      case Claim::kContact:
        return Whole(scoring::whole::kContact, seen_.contact);
      case Claim::kNotDone:
        return NotDone();
      case Claim::kOver:
        return There(m.place, true, false);
      case Claim::kLeft:
        return There(m.place, false, true);
      case Claim::kEither:
        return There(m.place, true, true);
    }
    return {};
  }

 private:
  std::string Whole(std::string_view kind, double seen_mm3) const {
    if (!(seen_mm3 > 0)) return "there is none of it";
    for (size_t i = 0; i < measures_.size(); ++i) {
      if (measures_[i].kind == kind && costs_[i].lost > 0) return {};
    }
    return "it cost nothing";
  }
  // The regions may have paid for it.
  std::string NotDone() const {
    if (!(seen_.left > 0)) return "nothing was left";
    for (const scoring::RegionCost& cost : costs_) {
      if (cost.lost > 0 && !cost.over) return {};
    }
    return "what was left cost nothing";
  }
  std::string There(const std::string& place, bool over, bool left) const {
    bool seen = false, paid = false;
    for (size_t i = 0; i < r_.regions().size(); ++i) {
      const bool there = IsAt(r_.regions()[i], place);
      // A line angle pays for the surfaces that meet in it.
      const bool pays = there || r_.regions()[i].kind == scoring::RegionKind::kLineAngle;
      paid |= pays && costs_[i].lost > 0 && (costs_[i].over ? over : left);
      if (!there) continue;
      seen |= (over && seen_.regions[i].over > 0) || (left && seen_.regions[i].left > 0);
    }
    // Beyond a region's edge, the same cut may cost as tissue taken elsewhere.
    if (!paid && over) paid = Whole(scoring::whole::kElsewhere, 1).empty();
    if (!seen) return over ? "nothing was cut too far there" : "nothing was left there";
    return paid ? "" : "it lost nothing by that";
  }
  const AcceptableCut& r_;
  const std::vector<scoring::RegionMeasure>& measures_;
  const std::vector<scoring::RegionCost>& costs_;
  const SeenCut seen_;
};

}  // namespace

bool IsAt(const scoring::Region& region, const std::string& place) {
  const std::string_view kind = scoring::NameOf(region.kind);
  return place.empty() || region.name == place || kind == place || kind.starts_with(place + "_");
}

Sides SidesOf(MistakeKind kind) {
  switch (ClaimOf(kind)) {
    case Claim::kOver:
    case Claim::kElsewhere:
    case Claim::kNeighbour:
    case Claim::kPulp:
      return {true, false};
    case Claim::kLeft:
    case Claim::kCaries:
    case Claim::kContact:
    case Claim::kNotDone:
      return {false, true};
    case Claim::kEither:
      break;
  }
  return {true, true};
}

Sentences CheckSentences(const AcceptableCut& r, const cutting::Volume& attempt,
                         const std::vector<scoring::RegionMeasure>& measures,
                         const std::vector<scoring::RegionCost>& costs,
                         const std::vector<scoring::Mistake>& mistakes) {
  Sentences out;
  if (std::ranges::none_of(mistakes, [](const auto& m) { return m.points > 0; })) return out;
  const Checker checker(r, measures, costs, Looker(r, attempt).Look());
  for (const scoring::Mistake& m : mistakes) {
    if (!(m.points > 0)) continue;
    ++out.said;
    // What nothing explains is said without a size.
    const bool sized = m.size > 0 || m.kind == MistakeKind::kUneven;
    const std::string wrong = sized ? checker.WrongWith(m) : "it has no size";
    if (wrong.empty()) continue;
    out.wrong.push_back(std::string(NameOf(m.kind)) + (m.place.empty() ? "" : " at " + m.place) +
                        ": " + wrong);
  }
  return out;
}

}  // namespace enamel::station::lab
