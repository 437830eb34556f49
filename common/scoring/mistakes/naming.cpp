#include "common/scoring/mistakes/naming.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

#include "common/scoring/mistakes/wall_fit.h"

namespace enamel::scoring {
namespace {

constexpr double kMm = 1e3;
// A groove is so many times longer than wide.
constexpr double kLong = 2.0;
// Shares of a wall's height: from kRimFrom up is the rim. A ledge is below kLow, and reaches to the foot but for the line
// angle.
constexpr double kRimFrom = 0.6, kLow = 0.4, kFoot_mm = 0.45;
// A lean is said where it moves the ends of a wall by more than this part of what moved all of it.
constexpr double kLeanSaid = 0.6;
// All of a wall's area, width or height; and half of its area. Shares. Chosen: a round bur that cuts all of a wall too far
// leaves its corners, a third of the area of a short one.
constexpr double kWhole = 0.66, kHalf = 0.5;
// A wall leans where a line explains so much (RegionFit::explained): at 0.1 mm, one that leans about its middle has 0.86
// to 1, and a rim of 0.4 of its height 0.83. Chosen.
constexpr double kLine = 0.86;
constexpr int kRowsOfLine = 3;
// Line angles are within this of the regions beside them.
constexpr double kBeside_mm = 0.4;
// Shares: of its peak, where a patch counts as touched; of a region, which then is named as a whole; of a
// patch, in each of two walls; of a group, that a part is most of.
constexpr double kTouched = 0.3, kMuch = 0.4, kSpans = 0.2, kMostly = 0.4;

class Namer {
 public:
  explicit Namer(const NamedFrom& from) : from_(from), r_(from.r) {}

  void Name(const MotionGroup& group, Mistake& m) const {
    const Displacement& first = *group.motions.front();
    if (group.Has(MotionKind::kShiftX) || group.Has(MotionKind::kShiftY)) {
      const dvec3 v(group.SizeOf(MotionKind::kShiftX), group.SizeOf(MotionKind::kShiftY), 0);
      m.kind = MistakeKind::kShifted;
      m.size = std::sqrt(Dot(v, v));
      m.towards = m.size > 0 ? v / m.size : v;
    } else if (group.Has(MotionKind::kTurn)) {
      m.kind = MistakeKind::kTurned;
      m.size = std::fabs(group.SizeOf(MotionKind::kTurn));
    } else if (group.Has(MotionKind::kTipX) || group.Has(MotionKind::kTipY)) {
      const dvec3 v(group.SizeOf(MotionKind::kTipX), group.SizeOf(MotionKind::kTipY), 0);
      m.kind = MistakeKind::kTipped;
      m.size = std::sqrt(Dot(v, v));
    } else if (group.Has(MotionKind::kSize) || group.Has(MotionKind::kTaper)) {
      NameWalls(HalfExtent_mm(group, 2), group.SizeOf(MotionKind::kSize),
                group.SizeOf(MotionKind::kTaper), m);
      m.place = r_.is_stump() ? "axial" : "wall";
    } else if (const int wall = group.OnlyWall(r_); wall >= 0) {
      NameOneWall(group, static_cast<size_t>(wall), m);
    } else if (IsLocal(first)) {
      NamePatch(group, m);
    } else {
      NameLevel(group, m);
    }
  }

  void NameOneWall(const MotionGroup& group, size_t region, Mistake& m) const {
    const RegionFit fit = FitRegion(r_, region, OwnOf(region));
    m.place = r_.regions()[region].name;
    // With fewer rows, a line fits any deviation.
    const bool leans =
        fit.rows >= kRowsOfLine && Leans(fit.half_height_mm, fit.moved_mm, fit.lean_deg);
    // A wall that was left short ends where caries or a pillar does.
    const bool most = fit.of_area >= kWhole ||
                      (fit.moved_mm < 0 && group.Has(MotionKind::kOffset) && fit.of_area >= kHalf);
    if (leans ? fit.explained >= kLine && fit.of_width >= kWhole : most) {
      NameWalls(fit.half_height_mm, fit.moved_mm, fit.lean_deg, m);
      if (!leans) m.size = std::fabs(fit.median_mm);
    } else {
      NamePatch(group, m);
    }
  }
  // The deviation less what other groups explain of the wall; all of it where they explain little, since the sparse fit
  // shares a little of every wall among motions of the whole.
  const std::vector<double>& OwnOf(size_t region) const {
    constexpr double kLittle = 0.3;
    double others = 0, all = 0;
    for (size_t i = 0; i < from_.off_mm.size(); ++i) {
      const SurfacePiece& piece = r_.pieces()[i];
      if (piece.region != region || piece.at_edge) continue;
      others += piece.area_m2 * std::fabs(from_.off_mm[i] - from_.rest_mm[i]);
      all += piece.area_m2 * std::fabs(from_.off_mm[i]);
    }
    return others < kLittle * all ? from_.off_mm : from_.rest_mm;
  }
  // Names a cut into a part of a wall.
  MistakeKind NameOfCut(const RegionFit& fit, bool is_long) const {
    const bool all_along = fit.of_width >= kWhole;
    const bool all_up = fit.of_height >= kWhole;
    // Along all of the rim, or from the foot to the rim over half of its width as far as its end, the wall is too far out
    // there. A groove has two sides.
    if (all_along && (fit.at_height > kRimFrom || fit.of_area >= kWhole)) return NameOfMoved(1);
    if (all_up && fit.of_width >= kHalf && fit.at_end) return NameOfMoved(1);
    return all_along || all_up || is_long ? MistakeKind::kGroove : MistakeKind::kPit;
  }
  static bool Leans(double half_height_mm, double moved_mm, double lean_deg) {
    return std::fabs(TangentOf(lean_deg)) * half_height_mm > kLeanSaid * std::fabs(moved_mm);
  }
  MistakeKind NameOfMoved(double by) const {
    if (r_.is_stump()) return by > 0 ? MistakeKind::kOverReduced : MistakeKind::kUnderReduced;
    return by > 0 ? MistakeKind::kOverExtended : MistakeKind::kUnderExtended;
  }

  // How far apart the pieces of the group lie along an axis, half.
  double HalfExtent_mm(const MotionGroup& group, int axis) const {
    double lo = 1e9, hi = -1e9;
    for (size_t i = 0; i < group.d_mm.size(); ++i) {
      if (group.d_mm[i] == 0) continue;
      const double at = r_.pieces()[i].at_m[axis] * kMm;
      lo = std::min(lo, at), hi = std::max(hi, at);
    }
    return hi > lo ? 0.5 * (hi - lo) : 0;
  }

  static double TangentOf(double degrees) { return degrees * std::numbers::pi / 180; }

  void NameWalls(double half_height_mm, double moved_mm, double lean_deg, Mistake& m) const {
    if (Leans(half_height_mm, moved_mm, lean_deg)) {
      // A cavity's wall that is farther out higher up opens; a stump's converges.
      m.kind = lean_deg > 0 ? MistakeKind::kLeansOut : MistakeKind::kLeansIn;
      m.size = std::fabs(lean_deg);
      return;
    }
    m.size = std::fabs(moved_mm);
    m.kind = NameOfMoved(moved_mm);
  }

  // Floors, tables, margins, faces.
  void NameLevel(const MotionGroup& group, Mistake& m) const {
    const Displacement& first = *group.motions.front();
    const bool one = first.region >= 0 && !group.Has(MotionKind::kHeight);
    const RegionKind kind = first.of;
    const auto region = std::ranges::find(r_.regions(), kind, &Region::kind);
    const auto number = static_cast<size_t>(region - r_.regions().begin());
    if (!group.Has(MotionKind::kSlopeX) && !group.Has(MotionKind::kSlopeY) &&
        region != r_.regions().end() && from_.wavy[number]) {
      NameWave(number, m);
      return;
    }
    m.place = one && std::ranges::count(r_.regions(), kind, &Region::kind) > 1
                  ? r_.regions()[static_cast<size_t>(first.region)].name
                  : std::string(NameOf(kind));
    const double moved_mm = group.Has(MotionKind::kHeight) ? group.SizeOf(MotionKind::kHeight)
                                                           : group.SizeOf(MotionKind::kOffset);
    const dvec3 slope(group.SizeOf(MotionKind::kSlopeX), group.SizeOf(MotionKind::kSlopeY), 0);
    const double ends_mm = std::fabs(TangentOf(slope.x)) * HalfExtent_mm(group, 0) +
                           std::fabs(TangentOf(slope.y)) * HalfExtent_mm(group, 1);
    if (ends_mm > kLeanSaid * std::fabs(moved_mm)) {
      m.kind = MistakeKind::kSlopes;
      m.size = std::sqrt(Dot(slope, slope));
      m.towards = m.size > 0 ? slope / m.size : slope;
      return;
    }
    m.size = std::fabs(moved_mm);
    const bool reduced = kind == RegionKind::kTable || kind == RegionKind::kFace;
    if (moved_mm > 0)
      m.kind = reduced ? MistakeKind::kOverReduced : MistakeKind::kDeep;
    else
      m.kind = reduced ? MistakeKind::kUnderReduced : MistakeKind::kShallow;
  }

  // Where along the height of its wall, 0 to 1.
  double HeightOn(int region, double z_m) const {
    double lo = 1e9, hi = -1e9;
    for (const SurfacePiece& piece : r_.pieces()) {
      if (piece.region != static_cast<uint32_t>(region)) continue;
      lo = std::min(lo, piece.at_m.z), hi = std::max(hi, piece.at_m.z);
    }
    return hi > lo ? (z_m - lo) / (hi - lo) : 0.5;
  }

  void NamePatch(const MotionGroup& group, Mistake& m) const {
    std::map<int, double> by_region;
    double all = 0;
    size_t over = 0;
    for (const Displacement* motion : group.motions) {
      over += motion->size > 0;
      for (size_t i = 0; i < motion->d_mm.size(); ++i) {
        const double part = std::fabs(motion->d_mm[i]) * r_.pieces()[i].area_m2;
        if (!(part > 0)) continue;
        by_region[static_cast<int>(r_.pieces()[i].region)] += part;
        all += part;
      }
    }
    const int main = std::ranges::max_element(by_region, {}, [&](const auto& entry) {
                       const bool pays = from_.paid[static_cast<size_t>(entry.first)] > 0;
                       return std::pair(pays, entry.second);
                     })->first;
    const Region& region = r_.regions()[static_cast<size_t>(main)];
    m.place = region.kind == RegionKind::kLineAngle ? BesideEdge(group) : region.name;
    const Touched touched = Touch(group, main);
    m.size = touched.off_mm;
    const double standing_mm3 =
        over > 0 || touched.share > kMuch
            ? 0
            : Standing_mm3(from_.faults, [&](size_t i) { return group.d_mm[i] < 0; });
    if (from_.wavy[static_cast<size_t>(main)]) {
      NameWave(static_cast<size_t>(main), m);
    } else if (standing_mm3 > 0) {
      m.kind = MistakeKind::kStanding;
      m.size = standing_mm3;
    } else if (const double hole_mm3 = over > 0 ? Hole_mm3(group) : 0; hole_mm3 > 0) {
      m.kind = MistakeKind::kHole;
      m.place.clear();
      m.size = hole_mm3;
    } else if (over > 0) {
      m.kind = KindOfOver(group, main, touched, all, m.at_m);
    } else {
      m.kind = SpansWalls(by_region, all)              ? MistakeKind::kCorner
               : region.kind == RegionKind::kLineAngle ? KindOfEdge(group)
                                                       : KindOfLeft(main, region, touched, m.at_m);
    }
  }
  // The region that is nearest to most of what was taken or left in its line angles.
  std::string BesideEdge(const MotionGroup& group) const {
    std::map<uint32_t, double> by_region;
    for (size_t e = 0; e < group.d_mm.size(); ++e) {
      if (group.d_mm[e] == 0) continue;
      for (size_t i = 0; i < group.d_mm.size(); ++i) {
        const SurfacePiece& piece = r_.pieces()[i];
        const dvec3 way = (piece.at_m - r_.pieces()[e].at_m) * kMm;
        if (r_.regions()[piece.region].kind == RegionKind::kLineAngle ||
            from_.off_mm[i] * group.d_mm[e] <= 0 || Dot(way, way) > kBeside_mm * kBeside_mm)
          continue;
        by_region[piece.region] += piece.area_m2 * std::fabs(from_.off_mm[i]);
      }
    }
    if (by_region.empty()) return r_.regions().back().name;
    const auto most =
        std::ranges::max_element(by_region, {}, [](const auto& e) { return e.second; });
    return r_.regions()[most->first].name;
  }

  // Along all regions of a kind but walls.
  void NameWave(size_t region, Mistake& m) const {
    const RegionKind kind = r_.regions()[region].kind;
    m.kind = MistakeKind::kWave;
    m.place = IsWall(kind) ? r_.regions()[region].name : std::string(NameOf(kind));
    double square = 0, area = 0;
    for (size_t i = 0; i < from_.off_mm.size(); ++i) {
      const SurfacePiece& piece = r_.pieces()[i];
      if (IsWall(kind) ? piece.region != region : r_.regions()[piece.region].kind != kind) continue;
      square += piece.area_m2 * from_.off_mm[i] * from_.off_mm[i], area += piece.area_m2;
    }
    m.size = area > 0 ? std::sqrt(square / area) : 0;
  }
  // Left between two walls, whose edge is upright, or along the foot of one.
  MistakeKind KindOfEdge(const MotionGroup& group) const {
    constexpr double kUpright = 0.35;
    double up = 0, all = 0;
    for (size_t i = 0; i < group.d_mm.size(); ++i) {
      const double part = std::fabs(group.d_mm[i]) * r_.pieces()[i].area_m2;
      up += part * std::fabs(r_.pieces()[i].normal.z), all += part;
    }
    return up < kUpright * all ? MistakeKind::kCorner : MistakeKind::kLedge;
  }

  // Volume of what was taken where the group is over, if it begins away from R's surface; else 0.
  double Hole_mm3(const MotionGroup& group) const {
    // Root mean square beyond the leeway, of a hole. Chosen.
    constexpr double kFar_m = 0.3e-3;
    double volume = 0, moment = 0, away = 0, elsewhere_m3 = 0;
    for (size_t i = 0; i < group.d_mm.size(); ++i) {
      if (!(group.d_mm[i] > 0)) continue;
      const PieceFault& fault = from_.faults.over[i];
      const auto& elsewhere = from_.faults.elsewhere[i];
      volume += fault.volume_m3;
      elsewhere_m3 += (1 - elsewhere.attached) * elsewhere.volume_m3;
      moment += fault.moment_m5;
      away += (1 - elsewhere.attached) * fault.moment_m5;
    }
    const bool hole = elsewhere_m3 > 0 && 2 * away > moment && moment > kFar_m * kFar_m * volume;
    return hole ? (volume + elsewhere_m3) * kMm * kMm * kMm : 0;
  }

  // How far a group moved one region, and how much of the region's area.
  struct Touched {
    double off_mm = 0, share = 0;
    double lowest_mm = 0;  // from the region's foot
  };
  Touched Touch(const MotionGroup& group, int region) const {
    double peak = 0, sum = 0, square = 0, area = 0, all = 0, foot_m = 1, lowest_m = 1;
    auto counts = [&](size_t i) { return r_.pieces()[i].region == static_cast<uint32_t>(region); };
    for (size_t i = 0; i < group.d_mm.size(); ++i) {
      if (counts(i)) peak = std::max(peak, std::fabs(group.d_mm[i]));
    }
    double fitted = 0, fitted_square = 0;  // where over and left are equal at each piece
    for (size_t i = 0; i < group.d_mm.size(); ++i) {
      const double moved = std::fabs(group.d_mm[i]);
      if (!counts(i)) continue;
      all += r_.pieces()[i].area_m2;
      foot_m = std::min(foot_m, r_.pieces()[i].at_m.z);
      if (moved < kTouched * peak) continue;
      lowest_m = std::min(lowest_m, r_.pieces()[i].at_m.z);
      const double weight = r_.pieces()[i].area_m2, off = std::fabs(from_.off_mm[i]);
      sum += weight * off;
      square += weight * off * off;
      fitted += weight * moved;
      fitted_square += weight * moved * moved;
      area += weight;
    }
    if (!(sum > 0)) sum = fitted, square = fitted_square;
    return {sum > 0 ? square / sum : 0, all > 0 ? area / all : 0, (lowest_m - foot_m) * kMm};
  }

  MistakeKind KindOfOver(const MotionGroup& group, int number, const Touched& touched, double all,
                         const dvec3& middle) const {
    const Region& region = r_.regions()[static_cast<size_t>(number)];
    const Displacement* part = LargestPart(group, all);
    const bool is_long = LengthOverWidth(r_, group.d_mm, middle) > kLong;
    if (IsWall(region.kind)) {
      const RegionFit fit = FitRegion(r_, static_cast<size_t>(number), from_.rest_mm);
      return NameOfCut(fit, part != nullptr || is_long);
    }
    const bool strip = part != nullptr && part->kind == MotionKind::kStrip;
    if (touched.share <= kMuch && (part == nullptr || strip))
      return part != nullptr || is_long ? MistakeKind::kGroove : MistakeKind::kPit;
    return IsReduced(region.kind) ? MistakeKind::kOverReduced : MistakeKind::kDeep;
  }

  MistakeKind KindOfLeft(int number, const Region& region, const Touched& touched,
                         const dvec3& middle) const {
    if (IsReduced(region.kind))
      return touched.share > kMuch ? MistakeKind::kUnderReduced : MistakeKind::kBump;
    if (region.kind == RegionKind::kMargin)
      return touched.share > kMuch ? MistakeKind::kShallow : MistakeKind::kLip;
    if (region.kind == RegionKind::kFloor)
      return touched.share > kMuch ? MistakeKind::kShallow : MistakeKind::kLedge;
    const double height = HeightOn(number, middle.z);
    return height > kRimFrom                               ? MistakeKind::kOverhang
           : touched.lowest_mm < kFoot_mm && height < kLow ? MistakeKind::kLedge
           : touched.share > kMuch                         ? MistakeKind::kUnderExtended
                                                           : MistakeKind::kBump;
  }

  static bool IsReduced(RegionKind kind) {
    return kind == RegionKind::kAxialWall || kind == RegionKind::kTable ||
           kind == RegionKind::kFace;
  }

  // A part of a region that is most of the group.
  const Displacement* LargestPart(const MotionGroup& group, double all) const {
    const Displacement* best = nullptr;
    double most = kMostly * all;
    for (const Displacement* m : group.motions) {
      if (m->kind != MotionKind::kPart && m->kind != MotionKind::kStrip) continue;
      double part = 0;
      for (size_t i = 0; i < m->d_mm.size(); ++i) {
        part += std::fabs(m->d_mm[i]) * r_.pieces()[i].area_m2;
      }
      if (part > most) best = m, most = part;
    }
    return best;
  }
  bool SpansWalls(const std::map<int, double>& by_region, double all) const {
    size_t walls = 0;
    for (const auto& [region, part] : by_region) {
      const RegionKind kind = r_.regions()[static_cast<size_t>(region)].kind;
      walls += kind == RegionKind::kWall && part > kSpans * all;
    }
    return walls >= 2;
  }

  const NamedFrom& from_;
  const AcceptableCut& r_;
};

}  // namespace

void NameMistake(const NamedFrom& from, const MotionGroup& group, Mistake& m) {
  Namer(from).Name(group, m);
}

}  // namespace enamel::scoring
