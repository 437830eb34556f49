#include "common/scoring/mistakes/groups.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>
#include <utility>

namespace enamel::scoring {
namespace {

constexpr double kMm = 1e3;
// Patches of one sign whose middles are this near are one; so is a patch and the wall that moved
// the same way by as much as this part of the patch.
constexpr double kNear_mm = 1.0, kSameMove = 0.5, kSameWall = 0.2;
// A region with so many patches of each sign is wavy.
constexpr size_t kWavy = 2;
constexpr double kEdgeReach_mm = 1.2, kTie = 1e-6;
// Half the leeway. A surface that moved by less everywhere looks right; its points are lost at a few places. Chosen.
constexpr double kMinMove_mm = 0.05;
// A piece has a mistake of its own where less than this part of it, and all but this much, is explained. Chosen.
constexpr double kExplained = 0.4, kUnseen_mm = 0.12;
// Pieces that no motion explains belong together where they are this near, and are named from so many points on. Chosen.
constexpr double kConnected_mm = 0.5, kTold = 0.5;

class Grouper {
 public:
  Grouper(const AcceptableCut& r, const FaultVolumes& faults,
          const std::vector<Displacement>& motions, const std::vector<double>& off_mm)
      : r_(r), faults_(faults), motions_(motions), off_mm_(off_mm) {}

  std::vector<MotionGroup> Make() {
    MakeGroups();
    TakePatches();
    MergeWalls();
    for (MotionGroup& group : groups_) Refit(group);
    ReachOverEdges();
    return std::move(groups_);
  }

 private:
  bool IsEdge(size_t piece) const { return r_.pieces()[piece].at_edge; }

  // All but patches, by what they move.
  void MakeGroups() {
    auto key = [&](const Displacement& m) -> std::pair<int, int> {
      switch (m.kind) {
        case MotionKind::kShiftX:
        case MotionKind::kShiftY:
          return {0, 0};
        case MotionKind::kTurn:
          return {1, 0};
        case MotionKind::kTipX:
        case MotionKind::kTipY:
          return {2, 0};
        case MotionKind::kSize:
        case MotionKind::kTaper:
          return {3, 0};
        case MotionKind::kHeight:
        case MotionKind::kSlopeX:
        case MotionKind::kSlopeY:
          return KeyOfKind(m.of);
        case MotionKind::kOffset:
        case MotionKind::kLean:
          return KeyOfRegion(m);
        case MotionKind::kPart:
        case MotionKind::kStrip:
        case MotionKind::kPatch:
          break;
      }
      return {6, 0};
    };
    std::map<std::pair<int, int>, MotionGroup> by_key;
    for (const Displacement& m : motions_) {
      if (!IsLocal(m)) by_key[key(m)].Take(m);
    }
    for (auto& [k, group] : by_key) {
      const double most_mm =
          std::ranges::max(group.d_mm, {}, [](double d) { return std::fabs(d); });
      if (std::fabs(most_mm) >= kMinMove_mm) groups_.push_back(std::move(group));
    }
  }
  static std::pair<int, int> KeyOfKind(RegionKind kind) { return {4, static_cast<int>(kind)}; }
  // The only floor moves and slopes as one.
  std::pair<int, int> KeyOfRegion(const Displacement& m) const {
    const auto same = std::ranges::count(r_.regions(), m.of, &Region::kind);
    return same == 1 && !IsWall(m.of) ? KeyOfKind(m.of) : std::pair(5, m.region);
  }

  void TakePatches() {
    std::vector<const Displacement*> patches;
    for (const Displacement& m : motions_) {
      if (IsLocal(m) && !JoinMove(m)) patches.push_back(&m);
    }
    Components parts(patches.size());
    for (size_t a = 0; a < patches.size(); ++a) {
      for (size_t b = 0; b < a; ++b) {
        const bool same = (patches[a]->size > 0) == (patches[b]->size > 0);
        if (same && Touch(*patches[a], *patches[b])) parts.Join(a, b);
      }
    }
    std::map<size_t, MotionGroup> clusters;
    for (size_t k = 0; k < patches.size(); ++k) clusters[parts.Of(k)].Take(*patches[k]);
    std::map<int, std::array<size_t, 2>> signs;
    for (const auto& [k, group] : clusters) {
      ++signs[group.motions.front()->region][group.motions.front()->size > 0];
    }
    std::map<int, MotionGroup> waves;
    for (auto& [k, group] : clusters) {
      const int region = group.motions.front()->region;
      if (signs[region][0] < kWavy || signs[region][1] < kWavy) {
        groups_.push_back(std::move(group));
        continue;
      }
      for (const Displacement* m : group.motions) waves[region].Take(*m);
    }
    for (auto& [region, group] : waves) groups_.push_back(std::move(group));
  }

  // Groups that overlap in one wall are one mistake: a lean, and a part that moved farther than the lean says.
  void MergeWalls() {
    for (size_t a = 0; a < groups_.size(); ++a) {
      for (size_t b = groups_.size(); b-- > a + 1;) {
        const int wall = groups_[a].OnlyWall(r_);
        if (wall < 0 || wall != groups_[b].OnlyWall(r_)) continue;
        if (!Overlap(groups_[a].d_mm, groups_[b].d_mm)) continue;
        for (const Displacement* m : groups_[b].motions) groups_[a].Take(*m);
        groups_.erase(groups_.begin() + static_cast<std::ptrdiff_t>(b));
      }
    }
  }
  static bool Overlap(const std::vector<double>& a, const std::vector<double>& b) {
    for (size_t i = 0; i < a.size(); ++i) {
      if (a[i] * b[i] > 0) return true;
    }
    return false;
  }

  static bool Touch(const Displacement& a, const Displacement& b) {
    const dvec3 way = (a.at_m - b.at_m) * kMm;
    return Dot(way, way) < kNear_mm * kNear_mm || Overlap(a.d_mm, b.d_mm);
  }

  // A patch that only says where a wall moved more than elsewhere belongs to that wall's mistake.
  bool JoinMove(const Displacement& patch) {
    size_t middle = 0;
    for (size_t i = 0; i < patch.d_mm.size(); ++i) {
      if (std::fabs(patch.d_mm[i]) > std::fabs(patch.d_mm[middle])) middle = i;
    }
    const double peak = patch.d_mm[middle];
    MotionGroup* best = nullptr;
    for (MotionGroup& group : groups_) {
      const double there = group.d_mm[middle];
      const Displacement& first = *group.motions.front();
      const bool same_wall =
          IsWall(first.of) && first.kind >= MotionKind::kOffset && first.region == patch.region;
      const double share = same_wall ? kSameWall : kSameMove;
      if (there * peak <= 0 || std::fabs(there) < share * std::fabs(peak)) continue;
      if (best == nullptr || std::fabs(there) > std::fabs(best->d_mm[middle])) best = &group;
    }
    if (best == nullptr) return false;
    best->Take(patch);
    return true;
  }

  // The explanation leaves pieces at edges out. A group moved them as it moved the nearest other pieces.
  void ReachOverEdges() {
    const auto& pieces = r_.pieces();
    for (size_t e = 0; e < pieces.size(); ++e) {
      if (!IsEdge(e)) continue;
      std::vector<double> sum(groups_.size());
      double weights = 0;
      for (size_t i = 0; i < pieces.size(); ++i) {
        if (IsEdge(i)) continue;
        const dvec3 way = (pieces[i].at_m - pieces[e].at_m) * kMm;
        const double t = 1 - Dot(way, way) / (kEdgeReach_mm * kEdgeReach_mm);
        if (t <= 0) continue;
        const double weight = t * pieces[i].area_m2;
        weights += weight;
        for (size_t g = 0; g < groups_.size(); ++g) sum[g] += weight * groups_[g].d_mm[i];
      }
      for (size_t g = 0; g < groups_.size(); ++g) {
        if (weights > 0) groups_[g].d_mm[e] = sum[g] / weights;
      }
    }
    for (size_t i = 0; i < pieces.size(); ++i) {
      LeaveToItself(i, 1, faults_.over[i]);
      LeaveToItself(i, -1, faults_.left[i]);
    }
  }
  // A piece that is off by much more than what moved it has a mistake of its own: a corner that was left.
  void LeaveToItself(size_t piece, double sign, const PieceFault& fault) {
    double explained = 0;
    for (const MotionGroup& group : groups_) explained += std::max(0.0, sign * group.d_mm[piece]);
    const double thickness_mm = Thickness_mm(fault);
    if (explained >= std::min(kExplained * thickness_mm, thickness_mm - kUnseen_mm)) return;
    for (MotionGroup& group : groups_) {
      if (sign * group.d_mm[piece] > 0) group.d_mm[piece] = 0;
    }
  }

  // The penalty draws sizes towards 0, and shares what two motions_ can say. For the words, the motions_ that name
  // the group are fitted to what no other group explains, without a penalty.
  void Refit(MotionGroup& group) const {
    group.sizes.assign(group.motions.size(), 0);
    std::vector<size_t> which;
    for (size_t k = 0; k < group.motions.size(); ++k) {
      group.sizes[k] = group.motions[k]->size;
      if (!IsLocal(*group.motions[k])) which.push_back(k);
    }
    const size_t n = which.size();
    if (n == 0) return;
    std::vector<std::vector<double>> rows(n, std::vector<double>(n + 1));
    for (size_t i = 0; i < off_mm_.size(); ++i) {
      if (IsEdge(i)) continue;
      double rest = off_mm_[i];
      for (const MotionGroup& other : groups_) {
        if (&other != &group) rest -= other.d_mm[i];
      }
      std::vector<double> phi(n);
      for (size_t a = 0; a < n; ++a) {
        const Displacement& m = *group.motions[which[a]];
        phi[a] = m.d_mm[i] / m.size;
      }
      const double area = r_.pieces()[i].area_m2 * kMm * kMm;
      for (size_t a = 0; a < n; ++a) {
        for (size_t b = 0; b < n; ++b) rows[a][b] += area * phi[a] * phi[b];
        rows[a][n] += area * phi[a] * rest;
      }
    }
    // Positive definite, but for motions_ that say the same.
    for (size_t a = 0; a < n; ++a) rows[a][a] *= 1 + kTie;
    for (size_t a = 0; a < n; ++a) {
      if (!(rows[a][a] > 0)) return;
      for (size_t b = a + 1; b < n; ++b) {
        const double part = rows[b][a] / rows[a][a];
        for (size_t c = a; c <= n; ++c) rows[b][c] -= part * rows[a][c];
      }
    }
    for (size_t a = n; a-- > 0;) {
      double value = rows[a][n];
      for (size_t b = a + 1; b < n; ++b) value -= rows[a][b] * group.sizes[which[b]];
      group.sizes[which[a]] = value / rows[a][a];
    }
  }

  const AcceptableCut& r_;
  const FaultVolumes& faults_;
  const std::vector<Displacement>& motions_;
  const std::vector<double>& off_mm_;
  std::vector<MotionGroup> groups_;
};

double PointsOf(const std::vector<CostlyPiece>& pieces) {
  double sum = 0;
  for (const CostlyPiece& each : pieces) sum += each.points;
  return sum;
}

Displacement BumpOf(const AcceptableCut& r, const FaultVolumes& faults,
                    const std::vector<CostlyPiece>& pieces) {
  Displacement bump;
  bump.kind = MotionKind::kPatch;
  bump.d_mm.assign(r.pieces().size(), 0);
  std::map<uint32_t, double> by_region;
  double most = 0;
  for (const CostlyPiece& each : pieces) {
    const PieceFault& fault = (each.over ? faults.over : faults.left)[each.piece];
    bump.d_mm[each.piece] = (each.over ? 1 : -1) * Thickness_mm(fault);
    by_region[r.pieces()[each.piece].region] += each.points;
    if (each.points <= most) continue;
    most = each.points;
    bump.at_m = r.pieces()[each.piece].at_m;
    bump.size = bump.d_mm[each.piece];
  }
  const auto region =
      std::ranges::max_element(by_region, {}, [](const auto& e) { return e.second; });
  bump.region = static_cast<int>(region->first);
  bump.of = r.regions()[region->first].kind;
  return bump;
}

}  // namespace

bool IsLocal(const Displacement& motion) {
  return motion.kind == MotionKind::kPart || motion.kind == MotionKind::kStrip ||
         motion.kind == MotionKind::kPatch;
}

void MotionGroup::Take(const Displacement& motion) {
  motions.push_back(&motion);
  if (d_mm.empty()) d_mm.assign(motion.d_mm.size(), 0);
  for (size_t i = 0; i < d_mm.size(); ++i) d_mm[i] += motion.d_mm[i];
}

int MotionGroup::OnlyWall(const AcceptableCut& r) const {
  constexpr double kNearlyAll = 0.8;
  std::map<int, double> by_region;
  double all = 0;
  for (const Displacement* motion : motions) {
    if (motion->region < 0) return -1;
    for (size_t i = 0; i < motion->d_mm.size(); ++i) {
      const double part = std::fabs(motion->d_mm[i]) * r.pieces()[i].area_m2;
      by_region[motion->region] += part, all += part;
    }
  }
  const auto most = std::ranges::max_element(by_region, {}, [](const auto& e) { return e.second; });
  const RegionKind of = r.regions()[static_cast<size_t>(most->first)].kind;
  return IsWall(of) && most->second > kNearlyAll * all ? most->first : -1;
}

bool MotionGroup::Has(MotionKind kind) const {
  return std::ranges::any_of(motions, [&](const Displacement* m) { return m->kind == kind; });
}

double MotionGroup::SizeOf(MotionKind kind) const {
  for (size_t k = 0; k < motions.size(); ++k) {
    if (motions[k]->kind == kind) return sizes[k];
  }
  return 0;
}

double Thickness_mm(const PieceFault& fault) {
  if (!(fault.moment_m5 > 0)) return 0;
  return (kLeeway_m + std::sqrt(3 * fault.moment_m5 / fault.volume_m3)) * kMm;
}

std::vector<Displacement> Unexplained(const AcceptableCut& r, const FaultVolumes& faults,
                                      const std::vector<MotionGroup>& groups,
                                      const std::vector<CostlyPiece>& costly) {
  const auto& pieces = r.pieces();
  std::vector<CostlyPiece> left;
  for (const CostlyPiece& each : costly) {
    const bool moved = std::ranges::any_of(groups, [&](const MotionGroup& group) {
      return (each.over ? 1 : -1) * group.d_mm[each.piece] > 0;
    });
    if (!moved) left.push_back(each);
  }
  Components parts(left.size());
  for (size_t a = 0; a < left.size(); ++a) {
    for (size_t b = 0; b < a; ++b) {
      const SurfacePiece &one = pieces[left[a].piece], &other = pieces[left[b].piece];
      const dvec3 way = (one.at_m - other.at_m) * kMm;
      if (left[a].over == left[b].over && Dot(way, way) < kConnected_mm * kConnected_mm)
        parts.Join(a, b);
    }
  }
  std::map<size_t, std::vector<CostlyPiece>> by_part;
  for (size_t a = 0; a < left.size(); ++a) by_part[parts.Of(a)].push_back(left[a]);
  std::vector<Displacement> out;
  // Small parts of line angles, by side: tissue left in all corners is one mistake.
  std::array<std::vector<CostlyPiece>, 2> small;
  auto tell = [&](const std::vector<CostlyPiece>& members) {
    const double points = PointsOf(members);
    if (points >= kTold) out.push_back(BumpOf(r, faults, members));
    return points >= kTold;
  };
  for (const auto& [part, members] : by_part) {
    const bool edge = std::ranges::any_of(members, [&](const CostlyPiece& each) {
      return r.regions()[pieces[each.piece].region].kind == RegionKind::kLineAngle;
    });
    if (tell(members) || !edge) continue;
    auto& of = small[members.front().over];
    of.insert(of.end(), members.begin(), members.end());
  }
  for (const auto& members : small) tell(members);
  return out;
}

std::vector<MotionGroup> GroupMotions(const AcceptableCut& r, const FaultVolumes& faults,
                                      const std::vector<Displacement>& motions,
                                      const std::vector<double>& off_mm) {
  return Grouper(r, faults, motions, off_mm).Make();
}

}  // namespace enamel::scoring
