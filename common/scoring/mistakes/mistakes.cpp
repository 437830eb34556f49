#include "common/scoring/mistakes/mistakes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <utility>

#include "common/scoring/mistakes/naming.h"
#include "common/scoring/mistakes/wall_fit.h"

namespace enamel::scoring {
namespace {

// Share of the task from which on it counts as not done at all. Chosen.
constexpr double kNothing_percent = 90;

class Finder {
 public:
  Finder(const AcceptableCut& r, const FaultVolumes& faults, const CutCost& cost)
      : r_(r),
        faults_(faults),
        cost_(cost),
        measures_(MeasuresOf(r, faults)),
        off_mm_(InMm(faults.off_m)),
        wavy_(Wavy()),
        motions_(Explain(r, off_mm_)),
        groups_(GroupMotions(r, faults, motions_, off_mm_)),
        costly_(CostlyPieces()),
        unexplained_(Unexplained(r, faults, groups_, OutsideWaves())) {
    for (const Displacement& bump : unexplained_) groups_.emplace_back().Take(bump);
    explained_mm_.assign(off_mm_.size(), 0);
    for (const MotionGroup& group : groups_) {
      for (size_t i = 0; i < off_mm_.size(); ++i) explained_mm_[i] += group.d_mm[i];
    }
  }

  FoundMistakes Find() {
    out_.resize(groups_.size());
    points_at_.resize(groups_.size());
    paid_.assign(groups_.size(), std::vector<double>(r_.regions().size()));
    paid_over_ = paid_;
    for (const CostlyPiece& each : costly_) ShareAt(each.piece, each.over ? 1 : -1, each.points);
    ShareRest();
    for (size_t g = 0; g < groups_.size(); ++g) {
      if (!(out_[g].points > 0)) continue;
      NameMistake({r_, faults_, off_mm_, RestFor(groups_[g]), wavy_, paid_[g]}, groups_[g],
                  out_[g]);
      if (!PaidWhereNamed(g)) NameWherePaid(g);
      if (!(out_[g].size > 0) || !IsTrue(out_[g])) CallUneven(g);
    }
    Join();
    return Sorted();
  }

 private:
  static std::vector<double> InMm(std::vector<double> off_m) {
    for (double& off : off_m) off *= 1e3;
    return off_m;
  }
  // The deviation less what the other groups explain.
  std::vector<double> RestFor(const MotionGroup& group) const {
    std::vector<double> out = off_mm_;
    for (size_t i = 0; i < out.size(); ++i) out[i] -= explained_mm_[i] - group.d_mm[i];
    return out;
  }
  std::vector<bool> Wavy() const {
    std::vector<bool> out(r_.regions().size());
    for (size_t k = 0; k < out.size(); ++k) out[k] = IsWavy(r_, k, off_mm_);
    return out;
  }
  // A hole beside a wall is paid for by the wall, too, and one wave by several regions.
  void Join() {
    std::map<std::pair<MistakeKind, std::string>, size_t> first;
    for (size_t i = 0; i < out_.size(); ++i) {
      Mistake& m = out_[i];
      if ((m.kind != MistakeKind::kHole && m.kind != MistakeKind::kWave) || !(m.points > 0))
        continue;
      const auto [found, is_new] = first.try_emplace({m.kind, m.place}, i);
      if (is_new) continue;
      Mistake& one = out_[found->second];
      joined_[i] = found->second;
      one.at_m = (one.points * one.at_m + m.points * m.at_m) / (one.points + m.points);
      one.size = m.kind == MistakeKind::kHole ? one.size + m.size : std::max(one.size, m.size);
      one.points += m.points;
      m.points = 0;
    }
  }
  FoundMistakes Sorted() {
    std::vector<int> order;
    for (size_t i = 0; i < out_.size(); ++i) {
      if (out_[i].points > 0) order.push_back(static_cast<int>(i));
    }
    std::ranges::stable_sort(order, std::greater<>(),
                             [&](int i) { return out_[static_cast<size_t>(i)].points; });
    FoundMistakes found;
    std::vector<int> place(out_.size(), -1);
    for (const int i : order) {
      place[static_cast<size_t>(i)] = static_cast<int>(found.mistakes.size());
      Mistake& m = out_[static_cast<size_t>(i)];
      m.group = GroupOfMistake(m);
      found.mistakes.push_back(std::move(m));
    }
    for (const auto& [i, one] : joined_) place[i] = place[one];
    for (const double sign : {1.0, -1.0}) {
      auto& of = sign > 0 ? found.over : found.left;
      of.assign(r_.pieces().size(), -1);
      for (size_t i = 0; i < of.size(); ++i) of[i] = PlaceOrNone(place, MostAt(i, sign));
    }
    return found;
  }
  // A motion of one region moves the pieces along its edges too, and may have been paid for there alone. Where its own
  // place has nothing of what the kind says, the sentence would be false.
  bool IsTrue(const Mistake& m) const {
    const int sign = SignOf(m.kind);
    if (sign == 0 || m.place.empty()) return true;
    const auto& faults = sign > 0 ? faults_.over : faults_.left;
    for (size_t i = 0; i < faults.size(); ++i) {
      // The edge may have paid for the voxels that are nearest to the region.
      if (IsAt(r_.pieces()[i].region, m.place) &&
          (faults[i].moment_m5 > 0 || sign * faults_.off_m[i] > kLeeway_m))
        return true;
    }
    return false;
  }
  bool IsAt(size_t region, const std::string& place) const {
    const Region& at = r_.regions()[region];
    const std::string_view kind = NameOf(at.kind);
    return at.name == place || kind == place || kind.starts_with(place + "_");
  }
  // True where the group lost points at the place that it is named after, and by the side that its kind
  // says. A motion may reach over several regions and to both sides. A line angle pays for the surfaces
  // that meet in it.
  bool PaidWhereNamed(size_t group) const {
    const Mistake& m = out_[group];
    if (SignOf(m.kind) == 0 || m.place.empty()) return true;
    for (size_t k = 0; k < r_.regions().size(); ++k) {
      const bool pays = r_.regions()[k].kind == RegionKind::kLineAngle || IsAt(k, m.place);
      const double over = paid_over_[group][k];
      if (pays && (SignOf(m.kind) > 0 ? over : paid_[group][k] - over) > 0) return true;
    }
    return false;
  }
  void NameWherePaid(size_t group) {
    const size_t region = MostPaid(group);
    Mistake& m = out_[group];
    const int sign = 2 * paid_over_[group][region] > paid_[group][region] ? 1 : -1;
    m.kind = sign > 0 ? MistakeKind::kPit : MistakeKind::kBump;
    m.place = r_.regions()[region].name;
    m.size = 0;
    for (size_t i = 0; i < off_mm_.size(); ++i) {
      if (r_.pieces()[i].region == region && sign * groups_[group].d_mm[i] > 0)
        m.size = std::max(m.size, sign * off_mm_[i]);
    }
  }
  size_t MostPaid(size_t group) const {
    return static_cast<size_t>(std::ranges::max_element(paid_[group]) - paid_[group].begin());
  }
  void CallUneven(size_t group) {
    Mistake& m = out_[group];
    m.kind = MistakeKind::kUneven;
    m.place = r_.regions()[MostPaid(group)].name;
    m.towards = dvec3(0);
  }
  static int PlaceOrNone(const std::vector<int>& place, int i) {
    return i < 0 ? -1 : place[static_cast<size_t>(i)];
  }
  // The number in out_ of what moved a piece most.
  int MostAt(size_t piece, double sign) const {
    int best = -1;
    double most = 0;
    for (size_t g = 0; g < groups_.size(); ++g) {
      const double part = sign * groups_[g].d_mm[piece];
      if (part > most) best = static_cast<int>(g), most = part;
    }
    if (best >= 0) return best;
    const auto uneven = uneven_.find({r_.pieces()[piece].region, sign > 0});
    return uneven == uneven_.end() ? -1 : uneven->second.number;
  }
  Group GroupOfMistake(const Mistake& m) const {
    switch (m.kind) {
      case MistakeKind::kHole:
      case MistakeKind::kNeighbour:
      case MistakeKind::kPulp:
        return Group::kTissuePreserved;
      case MistakeKind::kContact:
        return Group::kOutline;
      case MistakeKind::kCaries:
      case MistakeKind::kNotDone:
        return Group::kInternalForm;
      default:
        break;
    }
    const auto region = std::ranges::find(r_.regions(), m.place, &Region::name);
    if (region != r_.regions().end()) return GroupOf(NameOf(region->kind));
    if (m.place == "axial") return Group::kInternalForm;
    return m.place.empty() ? (r_.is_stump() ? Group::kInternalForm : Group::kOutline)
                           : GroupOf(m.place);
  }

  // Shares `points` of a piece among the groups that moved it in the direction of `sign`.
  void ShareAt(size_t piece, double sign, double points) {
    double sum = 0;
    for (const MotionGroup& group : groups_) sum += std::max(0.0, sign * group.d_mm[piece]);
    for (size_t g = 0; g < groups_.size(); ++g) {
      const double part = std::max(0.0, sign * groups_[g].d_mm[piece]);
      if (part > 0) Give(g, r_.pieces()[piece], points * part / sum, sign > 0);
    }
    if (sum > 0) return;
    Uneven& uneven = uneven_[{r_.pieces()[piece].region, sign > 0}];
    uneven.points += points;
    uneven.points_at += points * r_.pieces()[piece].at_m;
  }
  void Give(size_t group, const SurfacePiece& piece, double points, bool over) {
    out_[group].points += points;
    points_at_[group] += points * piece.at_m;
    paid_[group][piece.region] += points;
    if (over) paid_over_[group][piece.region] += points;
  }

  // Divides each region's points among its pieces, by their moments.
  std::vector<CostlyPiece> CostlyPieces() const {
    std::vector<CostlyPiece> out;
    for (size_t row = 0; row < r_.regions().size(); ++row) {
      const RegionCost& cost = cost_.rows[row];
      if (!(cost.lost > 0) || (!cost.over && NothingDone())) continue;
      const auto& faults = cost.over ? faults_.over : faults_.left;
      double all = 0;
      auto counts = [&](size_t i) { return r_.pieces()[i].region == row; };
      for (size_t i = 0; i < faults.size(); ++i) {
        if (counts(i)) all += faults[i].moment_m5;
      }
      for (size_t i = 0; i < faults.size(); ++i) {
        if (!counts(i) || faults[i].moment_m5 <= 0) continue;
        out.push_back({static_cast<uint32_t>(i), cost.over, cost.lost * faults[i].moment_m5 / all});
      }
    }
    return out;
  }
  // The rest of a wavy region is a wave and no bumps.
  std::vector<CostlyPiece> OutsideWaves() const {
    std::vector<CostlyPiece> out;
    for (const CostlyPiece& each : costly_) {
      if (!wavy_[r_.pieces()[each.piece].region]) out.push_back(each);
    }
    return out;
  }
  // Where nearly nothing was cut, nobody speaks of walls.
  bool NothingDone() const {
    const auto row = std::ranges::find(measures_, whole::kNotDone, &RegionMeasure::kind);
    return row != measures_.end() && row->left >= kNothing_percent;
  }
  double PaidForNothing() const {
    double out = 0;
    if (!NothingDone()) return out;
    for (size_t row = 0; row < measures_.size(); ++row) {
      const bool counts = row < r_.regions().size() || measures_[row].kind == whole::kContact;
      if (counts && !cost_.rows[row].over) out += cost_.rows[row].lost;
    }
    return out;
  }

  // Shares the rows that belong to no region.
  void ShareRest() {
    const size_t groups = groups_.size();
    for (size_t i = r_.regions().size(); i < measures_.size(); ++i) {
      double lost = cost_.rows[i].lost;
      if (measures_[i].kind == whole::kContact && NothingDone()) continue;
      if (measures_[i].kind == whole::kNotDone) lost += PaidForNothing();
      if (!(lost > 0)) continue;
      Mistake mistake;
      mistake.points = lost;
      mistake.size = cost_.rows[i].over ? measures_[i].over : measures_[i].left;
      if (measures_[i].kind == whole::kElsewhere) {
        ShareElsewhere(lost);
        continue;
      }
      mistake.kind = measures_[i].kind == whole::kNeighbour ? MistakeKind::kNeighbour
                     : measures_[i].kind == whole::kPulp    ? MistakeKind::kPulp
                     : measures_[i].kind == whole::kCaries  ? MistakeKind::kCaries
                     : measures_[i].kind == whole::kContact ? MistakeKind::kContact
                                                            : MistakeKind::kNotDone;
      mistake.at_m = MiddleOf(measures_[i], mistake.place);
      rest_.push_back(mistake);
    }
    for (size_t g = 0; g < groups; ++g) {
      if (out_[g].points > 0) out_[g].at_m = points_at_[g] / out_[g].points;
    }
    for (auto& [where, uneven] : uneven_) {
      const uint32_t region = where.first;
      const bool over = where.second;
      uneven.number = static_cast<int>(groups + rest_.size());
      Mistake mistake;
      mistake.points = uneven.points;
      mistake.at_m = uneven.points_at / uneven.points;
      mistake.place = r_.regions()[region].name;
      auto there = [&](size_t i) { return r_.pieces()[i].region == region; };
      if (const double mm3 = over ? 0 : Standing_mm3(faults_, there); mm3 > 0) {
        mistake.kind = MistakeKind::kStanding;
        mistake.size = mm3;
      }
      rest_.push_back(mistake);
    }
    out_.insert(out_.end(), rest_.begin(), rest_.end());
  }

  // The middle of the whole task, or of a third of a contact, whose name `place` gets.
  dvec3 MiddleOf(const RegionMeasure& measure, std::string& place) const {
    if (measure.kind != whole::kContact) return MiddleOfTask();
    place = measure.name;
    return std::ranges::find(r_.contact()->thirds(), place, &Contact::Third::name)->at_m;
  }
  dvec3 MiddleOfTask() const {
    dvec3 sum(0);
    double area = 0;
    for (const SurfacePiece& piece : r_.pieces())
      sum += piece.area_m2 * piece.at_m, area += piece.area_m2;
    return area > 0 ? sum / area : sum;
  }

  // A cut that continues from a wall belongs to the mistake that moved the wall; the rest is a hole.
  void ShareElsewhere(double points) {
    double all = faults_.far_m3;
    for (const auto& e : faults_.elsewhere) all += e.volume_m3;
    double hole_m3 = faults_.far_m3;
    dvec3 at = faults_.far_m3 * faults_.far_at_m;
    for (size_t i = 0; i < faults_.elsewhere.size(); ++i) {
      const auto& e = faults_.elsewhere[i];
      const double own = MostAt(i, 1) < 0 ? 0 : e.attached;
      if (e.volume_m3 * own > 0) ShareAt(i, 1, points * e.volume_m3 * own / all);
      hole_m3 += (1 - own) * e.volume_m3;
      at += (1 - own) * e.moment_m4;
    }
    if (hole_m3 <= 0) return;
    Mistake hole;
    hole.kind = MistakeKind::kHole;
    hole.size = hole_m3 * 1e9;
    hole.at_m = at / hole_m3;
    hole.points = points * hole_m3 / all;
    rest_.push_back(hole);
  }

  const AcceptableCut& r_;
  const FaultVolumes& faults_;
  const CutCost& cost_;
  const std::vector<RegionMeasure> measures_;
  const std::vector<double> off_mm_;
  const std::vector<bool> wavy_;  // by region
  const std::vector<Displacement> motions_;
  std::vector<MotionGroup> groups_;
  const std::vector<CostlyPiece> costly_;
  const std::vector<Displacement> unexplained_;
  std::vector<double> explained_mm_;  // by all groups
  std::vector<Mistake> out_, rest_;
  std::map<size_t, size_t> joined_;  // in out_: what another one says, too
  std::vector<dvec3> points_at_;
  std::vector<std::vector<double>> paid_;       // by group and region
  std::vector<std::vector<double>> paid_over_;  // of it, for what was cut too far
  struct Uneven {
    double points = 0;
    dvec3 points_at{0};
    int number = -1;  // in out_
  };
  std::map<std::pair<uint32_t, bool>, Uneven> uneven_;  // by region and whether it is over
};

}  // namespace

FoundMistakes FindMistakes(const AcceptableCut& r, const FaultVolumes& faults,
                           const CutCost& cost) {
  return Finder(r, faults, cost).Find();
}

}  // namespace enamel::scoring
