#include "common/scoring/mistakes/mistakes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <utility>

#include "common/scoring/mistakes/naming.h"

namespace enamel::scoring {
namespace {

// A region goes both ways where the smaller share of the squares is at least this. Chosen.
constexpr double kBothWays = 0.2;

class Finder {
 public:
  Finder(const AcceptableCut& r, const FaultVolumes& faults, const CutCost& cost)
      : r_(r),
        faults_(faults),
        cost_(cost),
        off_mm_(Deviation_mm(r, faults)),
        motions_(Explain(r, off_mm_)),
        groups_(GroupMotions(r, motions_, off_mm_)) {}

  std::vector<Mistake> Find() {
    out_.resize(groups_.size());
    points_at_.resize(groups_.size());
    ShareRegions();
    ShareRest();
    for (size_t g = 0; g < groups_.size(); ++g) {
      if (out_[g].points > 0) NameMistake({r_, faults_, off_mm_}, groups_[g], out_[g]);
    }
    std::erase_if(out_, [](const Mistake& m) { return !(m.points > 0); });
    std::ranges::stable_sort(out_, std::greater<>(), &Mistake::points);
    return std::move(out_);
  }

 private:
  // Shares `points` of a piece among the groups that moved it in the direction of `sign`.
  void ShareAt(size_t piece, double sign, double points) {
    double sum = 0;
    for (const Group& group : groups_) sum += std::max(0.0, sign * group.d_mm[piece]);
    for (size_t g = 0; g < groups_.size(); ++g) {
      const double part = std::max(0.0, sign * groups_[g].d_mm[piece]);
      if (part > 0) Give(g, r_.pieces()[piece].at_m, points * part / sum);
    }
    if (sum > 0) return;
    Uneven& uneven = uneven_[{r_.pieces()[piece].region, sign > 0}];
    uneven.points += points;
    uneven.points_at += points * r_.pieces()[piece].at_m;
  }
  void Give(size_t group, const dvec3& at_m, double points) {
    out_[group].points += points;
    points_at_[group] += points * at_m;
  }

  void ShareRegions() {
    for (const RegionCost& row : cost_.rows) {
      if (row.region < 0) continue;
      const bool over = row.measure == Measure::kOver;
      const auto& faults = over ? faults_.over : faults_.left;
      double all = 0;
      auto counts = [&](size_t i) {
        return r_.pieces()[i].region == static_cast<uint32_t>(row.region);
      };
      for (size_t i = 0; i < faults.size(); ++i) {
        if (counts(i)) all += faults[i].moment_m5;
      }
      for (size_t i = 0; i < faults.size(); ++i) {
        if (!counts(i) || faults[i].moment_m5 <= 0) continue;
        ShareAt(i, over ? 1 : -1, row.points * faults[i].moment_m5 / all);
      }
    }
  }

  // Shares the rows that belong to no region.
  void ShareRest() {
    const size_t groups = groups_.size();
    for (const RegionCost& row : cost_.rows) {
      if (row.region >= 0) continue;
      Mistake mistake;
      mistake.size = row.size;
      mistake.points = row.points;
      switch (row.measure) {
        case Measure::kElsewhere:
          ShareElsewhere(row.points);
          continue;
        case Measure::kNeighbour:
          mistake.kind = MistakeKind::kNeighbour;
          break;
        case Measure::kPulp:
          mistake.kind = MistakeKind::kPulp;
          break;
        case Measure::kCaries:
          mistake.kind = MistakeKind::kCaries;
          break;
        default:
          mistake.kind = MistakeKind::kNotDone;
          break;
      }
      rest_.push_back(mistake);
    }
    for (size_t g = 0; g < groups; ++g) {
      if (out_[g].points > 0) out_[g].at_m = points_at_[g] / out_[g].points;
    }
    for (const auto& [where, uneven] : uneven_) {
      const auto [region, over] = where;
      Mistake mistake;
      mistake.points = uneven.points;
      mistake.at_m = uneven.points_at / uneven.points;
      mistake.place = r_.regions()[region].name;
      auto there = [&](size_t i) { return r_.pieces()[i].region == where.first; };
      if (const double mm3 = over ? 0 : Standing_mm3(faults_, there); mm3 > 0) {
        mistake.kind = MistakeKind::kStanding;
        mistake.size = mm3;
      } else if (const double rms_mm = Waves_mm(region); rms_mm > 0) {
        mistake.kind = MistakeKind::kWave;
        mistake.size = rms_mm;
      }
      rest_.push_back(mistake);
    }
    out_.insert(out_.end(), rest_.begin(), rest_.end());
  }

  // Root mean square of what no motion explains of a region, where it goes both ways; else 0.
  double Waves_mm(uint32_t region) const {
    double square = 0, area = 0, over = 0;
    for (size_t i = 0; i < off_mm_.size(); ++i) {
      if (r_.pieces()[i].region != region) continue;
      double rest = off_mm_[i];
      for (const Group& group : groups_) rest -= group.d_mm[i];
      const double weight = r_.pieces()[i].area_m2;
      square += weight * rest * rest;
      area += weight;
      if (rest > 0) over += weight * rest * rest;
    }
    const bool both = over > kBothWays * square && over < (1 - kBothWays) * square;
    return both && area > 0 ? std::sqrt(square / area) : 0;
  }

  void ShareElsewhere(double points) {
    double all = faults_.far_m3;
    for (const double v : faults_.elsewhere_m3) all += v;
    for (size_t i = 0; i < faults_.elsewhere_m3.size(); ++i) {
      if (faults_.elsewhere_m3[i] > 0) ShareAt(i, 1, points * faults_.elsewhere_m3[i] / all);
    }
    if (faults_.far_m3 <= 0) return;
    Mistake hole;
    hole.kind = MistakeKind::kHole;
    hole.size = faults_.far_m3 * 1e9;
    hole.at_m = faults_.far_at_m;
    hole.points = points * faults_.far_m3 / all;
    rest_.push_back(hole);
  }

  const AcceptableCut& r_;
  const FaultVolumes& faults_;
  const CutCost& cost_;
  const std::vector<double> off_mm_;
  const std::vector<Motion> motions_;
  const std::vector<Group> groups_;
  std::vector<Mistake> out_, rest_;
  std::vector<dvec3> points_at_;
  struct Uneven {
    double points = 0;
    dvec3 points_at{0};
  };
  std::map<std::pair<uint32_t, bool>, Uneven> uneven_;  // by region and whether it is over
};

}  // namespace

std::string_view NameOf(MistakeKind kind) {
  constexpr std::array<std::string_view, kMistakeKinds> kNames = {
      "shifted",       "turned",   "tipped",    "over_extended", "under_extended",
      "leans_out",     "leans_in", "deep",      "shallow",       "over_reduced",
      "under_reduced", "slopes",   "groove",    "pit",           "ledge",
      "overhang",      "lip",      "corner",    "bump",          "standing",
      "wave",          "hole",     "neighbour", "pulp",          "caries",
      "not_done",      "uneven"};
  return kNames[static_cast<size_t>(kind)];
}

std::vector<Mistake> FindMistakes(const AcceptableCut& r, const FaultVolumes& faults,
                                  const CutCost& cost) {
  return Finder(r, faults, cost).Find();
}

}  // namespace enamel::scoring
