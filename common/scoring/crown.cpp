#include "common/scoring/crown.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "common/math/trig.h"
#include "common/scoring/half_planes.h"
#include "common/scoring/planes.h"

namespace enamel::scoring {
namespace {

using cutting::Tissue;
using cutting::Volume;
using namespace half_planes;

constexpr double kDegrees = 180 / 3.14159265358979323846;
constexpr double kSearch_m = 1.5e-3;   // about where the shoulder should be
constexpr double kMinStep_m = 0.1e-3;  // a wall stands so far in from the tooth's side, at least
// Walls are measured from this far above the finish line, where a shoulder's inner edge is round,
// to this far below the top, whose edge is round. The top falls towards a premolar's mesial and distal
// edges: it is the lowest of what lies this far inside the wall.
constexpr double kWallMargin_m = 0.5e-3, kMinWall_m = 1e-3;
constexpr double kMaxMissing = 0.3;
constexpr double kFinishInside_m = 0.15e-3;  // the finish line's height is taken so far in
constexpr double kWidthAbove_m = 0.3e-3;     // and its width so far above it
constexpr double kCompleteWidth_m = 0.3e-3;
constexpr double kNoLine_m = 0.75e-3;  // a ledge so far above it is not the finish line
// A bevel: between a table's inclines, which fall inwards or are flatter, and the wall.
constexpr double kBevelLeast = 0.57735026918962573, kBevelMost = 2.1445069205095586;  // tan 30, 65
constexpr double kMinBevel_m = 0.2e-3;
constexpr int kBevelPlaces = 5;                  // to either side
constexpr double kMinReduction_m = 0.5e-3;       // of a wall that the task reduces
constexpr double kLeans = 0.034899496702500969;  // sin of 2 degrees

// The reference's finish line at one place around the axis.
struct Place {
  double line_z_m = 0;  // of the finish line
  double outer_m = 0;   // the tooth's side there, from the axis
};

double Median(std::vector<double> values) {
  if (values.empty()) return 0;
  const size_t middle = values.size() / 2;
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(middle),
                   values.end());
  return values[middle];
}
// The value that 95 % of the values exceed.
double LeastOfMost(std::vector<double> values) {
  if (values.empty()) return 0;
  std::sort(values.begin(), values.end());
  return values[values.size() / 20];
}

// The middle of the reference's stump, without neighbours, a millimetre above the shoulder.
std::optional<dvec3> AxisOf(const Volume& reference, const dvec3& landmark_m, double z_m) {
  const double step = reference.spec().voxel_m();
  dvec3 sum(0);
  double count = 0;
  for (double x = -kReach_m; x <= kReach_m; x += step) {
    for (double y = -kReach_m; y <= kReach_m; y += step) {
      const dvec3 p(landmark_m.x + x, landmark_m.y + y, z_m);
      if (reference.DistanceAt_m(p) >= 0 || reference.TissueAtPoint(p) == Tissue::kNeighbour) {
        continue;
      }
      sum += p;
      ++count;
    }
  }
  if (count == 0) return std::nullopt;
  return sum / count;
}

// The lowest height from which the reference's wall is inside the tooth's side.
std::optional<Place> FinishLine(const Profile& initial, const Profile& reference,
                                const Direction& d, double bottom_z_m) {
  const double step = reference.step_m();
  double above_z = 0, above_in = -1;
  for (double z = bottom_z_m + kSearch_m; z > bottom_z_m - kSearch_m; z -= step) {
    const std::optional<double> outer = initial.Radius_m(d, z), inner = reference.Radius_m(d, z);
    if (!outer || !inner) return std::nullopt;
    const double in = *outer - *inner;
    if (in < kMinStep_m) {
      if (above_in < 0) return std::nullopt;  // no wall stands in above it
      const double t = (kMinStep_m - in) / (above_in - in);
      return Place{z + t * (above_z - z), *outer};
    }
    above_z = z, above_in = in;
  }
  return std::nullopt;
}

struct Line {
  double slope = 0;  // dr / dz
  double median_radius_m = 0;
};
// The wall of a half plane between two heights, by most of it: a pit in it is no lean.
std::optional<Line> WallLine(const Profile& profile, const Direction& d, double lo_z_m,
                             double hi_z_m) {
  std::vector<double> radii;
  std::vector<Height> heights;
  double looked = 0;
  for (double z = lo_z_m; z <= hi_z_m; z += profile.step_m()) {
    ++looked;
    const std::optional<double> r = profile.Radius_m(d, z);
    if (!r) continue;
    heights.push_back({.d = *r, .area = 1, .s = z});
    radii.push_back(*r);
  }
  const auto n = static_cast<double>(radii.size());
  if (n < 3 || n < (1 - kMaxMissing) * looked) return std::nullopt;
  return Line{FitPlaneToMost(heights, 0.5 * profile.step_m()).b, Median(std::move(radii))};
}

// Where the wall of a half plane ends at the top, at least a wall's height above the finish line.
double WallTop_m(const Profile& reference, const Direction& d, double line_z_m, double top_z_m) {
  const double least = line_z_m + 2 * kWallMargin_m + kMinWall_m;
  const double foot = reference.Radius_m(d, line_z_m + kWallMargin_m).value_or(0);
  double lowest = top_z_m;
  for (double r = 0; r < foot - kWallMargin_m; r += reference.step_m()) {
    if (const auto z = reference.Height_m(d, r, top_z_m + reference.step_m(), least))
      lowest = std::min(lowest, *z);
  }
  return std::max(lowest, least);
}

// Everything about the finish line, at the places that the reference has.
void MeasureLine(const Profile& initial, const Profile& attempt, const Profile& reference,
                 const std::array<Direction, kPlaces>& directions,
                 const std::array<Place, kPlaces>& places, CrownFigures& out) {
  std::vector<double> widths, depths;
  double complete = 0;
  for (size_t k = 0; k < directions.size(); ++k) {
    const Direction& d = directions[k];
    const Place& at = places[k];
    // A tooth that is narrower farther down would end outside of a deeper line.
    auto inside = [&](double z) {
      const double outer = z >= at.line_z_m ? at.outer_m : initial.Radius_m(d, z).value_or(0);
      return std::min(at.outer_m, outer) - kFinishInside_m;
    };
    const double from = at.line_z_m + 2 * kSearch_m, to = at.line_z_m - kSearch_m;
    // Where the air begins higher, the tooth's side was left, and there is no line at this height.
    const bool left = attempt.IsSolid(d, inside(from), from);
    const double is = left ? from : attempt.HeightWhere_m(d, inside, from, to).value_or(to);
    const double asked = reference.HeightWhere_m(d, inside, from, to).value_or(at.line_z_m);
    depths.push_back(asked - is);
    const std::optional<double> inner = attempt.Radius_m(d, is + kWidthAbove_m);
    widths.push_back(inner ? std::max(0.0, at.outer_m - *inner) : 0);
    if (widths.back() >= kCompleteWidth_m) ++complete;
  }
  out.width_m = Median(widths);
  out.width_least_m = LeastOfMost(widths);
  out.depth_m = Median(depths);
  double sum = 0, made = 0;
  for (size_t k = 0; k < depths.size(); ++k) {
    const double square = (depths[k] - out.depth_m) * (depths[k] - out.depth_m);
    sum += square;
    if (widths[k] >= kCompleteWidth_m) made += square;
  }
  out.waviness_m = std::sqrt(sum / kPlaces);
  out.waviness_made_m = complete > 0 ? std::sqrt(made / complete) : 0;
  out.complete = complete / kPlaces;
  // Twice around, so that a stretch may run over the first place.
  size_t stretch = 0, longest = 0;
  for (size_t k = 0; k < 2 * widths.size(); ++k) {
    const size_t at = k % widths.size();
    const bool none = widths[at] < kMinStep_m || depths[at] < -kNoLine_m;
    stretch = none ? stretch + 1 : 0;
    longest = std::max(longest, std::min(stretch, widths.size()));
  }
  out.missing_deg = 360.0 * static_cast<double>(longest) / kPlaces;
}

// The outermost stretch of a half plane's top that falls outwards as a bevel does: its width along
// the surface and the mean of its slopes; none where there is less than kMinBevel_m of it.
struct Stretch {
  double width_m = 0, slope = 0;
};
std::optional<Stretch> BevelOf(const Profile& profile, const Direction& d, double outer_m,
                               double from_z_m, double to_z_m) {
  const double step = profile.step_m();
  constexpr size_t kBase = 2;   // steps: a voxel
  std::vector<double> heights;  // from the tooth's side inwards
  for (double r = outer_m; r > 0; r -= step) {
    heights.push_back(profile.Height_m(d, r, from_z_m, to_z_m).value_or(to_z_m));
  }
  double run = 0, rise = 0;
  size_t gap = 0;
  for (size_t i = 0; i + kBase < heights.size(); ++i) {
    const double slope = (heights[i + kBase] - heights[i]) / (kBase * step);
    if (slope >= kBevelLeast && slope <= kBevelMost) {
      run += step, rise += slope * step;
      gap = 0;
    } else if (run > 0 && ++gap > kBase) {
      if (run > kMinBevel_m) break;
      run = rise = 0;  // the wall's foot or its upper edge
      gap = 0;
    }
  }
  if (!(run > 0)) return std::nullopt;
  const double slope = rise / run;
  // Steps that begin on the bevel and end on the table count to about half; steps that begin on the
  // wall do not count.
  const double width = (run + 0.5 * kBase * step) * std::sqrt(1 + slope * slope);
  if (width < kMinBevel_m) return std::nullopt;
  return Stretch{width, slope};
}

BevelFigures MeasureBevel(const Profile& attempt, const std::array<Direction, kPlaces>& directions,
                          const std::array<Place, kPlaces>& places, int middle, double sky_z_m) {
  std::vector<double> widths, slopes;
  for (int k = middle - kBevelPlaces; k <= middle + kBevelPlaces; ++k) {
    const auto at = static_cast<size_t>(k);
    const Place& place = places[at];
    if (const auto bevel = BevelOf(attempt, directions[at], place.outer_m, sky_z_m,
                                   place.line_z_m + kWallMargin_m)) {
      widths.push_back(bevel->width_m);
      slopes.push_back(bevel->slope);
    }
  }
  BevelFigures out;
  out.made = 2 * widths.size() > 2 * kBevelPlaces;
  if (!out.made) return out;
  out.width_m = Median(std::move(widths));
  out.angle_deg = kDegrees * ArcTan(Median(std::move(slopes)));
  return out;
}

// Straight down, within the stump's top as the reference has it, on rings of as many places each:
// the middle counts more than its area.
void MeasureTop(const Volume& initial, const Volume& attempt, const Volume& reference,
                const dvec3& axis_m, double top_z_m, double radius_m,
                const std::array<Direction, kPlaces>& directions, CrownFigures& out) {
  const double step = 2 * initial.spec().voxel_m();
  const Profile before(initial, axis_m), after(attempt, axis_m), wanted(reference, axis_m);
  const double from = initial.spec().origin_m().z +
                      static_cast<double>(initial.spec().voxels().z) * initial.spec().voxel_m();
  std::vector<double> taken;
  for (double r = 0; r <= radius_m; r += step) {
    for (const Direction& d : directions) {
      const std::optional<double> was = before.Height_m(d, r, from, top_z_m - 2e-3);
      const std::optional<double> asked = wanted.Height_m(d, r, from, top_z_m - 2e-3);
      if (!was || !asked) continue;
      const std::optional<double> is = after.Height_m(d, r, from, top_z_m - 4e-3);
      taken.push_back(*was - is.value_or(top_z_m - 4e-3));
      if (r == 0) break;
    }
  }
  out.top_m = Median(taken);
  out.top_least_m = LeastOfMost(std::move(taken));
}

double Undercut_m2(const CutSide& attempt, const dvec3& axis_m, double lo_z_m, double hi_z_m) {
  double sum = 0;
  const surface::Mesh& mesh = *attempt.mesh;
  for (size_t i = 0; i < mesh.position_m.size(); ++i) {
    if (!(*attempt.cut)[i] || mesh.tissue[i] == static_cast<uint8_t>(Tissue::kNeighbour)) continue;
    const dvec3 p(mesh.position_m[i]);
    if (p.z < lo_z_m || p.z > hi_z_m || mesh.normal[i].z > -kLeans) continue;
    const double out = (p.x - axis_m.x) * mesh.normal[i].x + (p.y - axis_m.y) * mesh.normal[i].y;
    if (out > 0) sum += (*attempt.areas_m2)[i];
  }
  return sum;
}

}  // namespace

bool IsCrown(const scene::CavityTarget& target) {
  using Outline = scene::PreparationPart::Outline;
  return target.landmark == "crown_top" || !target.prepared.IsZero() ||
         std::any_of(target.parts.begin(), target.parts.end(),
                     [](const auto& part) { return part.outline == Outline::kStump; });
}

CrownFigures MeasureCrown(const Volume& initial, const CutSide& attempt, const CutSide& reference,
                          const dvec3& landmark_m, double bottom_z_m, int mesial_x) {
  CrownFigures out;
  const std::optional<dvec3> axis = AxisOf(*reference.volume, landmark_m, bottom_z_m + 1e-3);
  if (!axis) return out;
  const Profile before(initial, *axis), is(*attempt.volume, *axis), asked(*reference.volume, *axis);
  static const std::array<Direction, kPlaces> directions = Directions();

  std::array<Place, kPlaces> places;
  double line_z = bottom_z_m - kSearch_m;  // the highest
  for (size_t k = 0; k < directions.size(); ++k) {
    const std::optional<Place> place = FinishLine(before, asked, directions[k], bottom_z_m);
    if (!place) return out;
    places[k] = *place;
    line_z = std::max(line_z, place->line_z_m);
  }
  // Up to where the axis comes out: above it, only cusps.
  const double sky = initial.spec().origin_m().z +
                     static_cast<double>(initial.spec().voxels().z) * initial.spec().voxel_m();
  const std::optional<double> top = asked.Height_m(directions[0], 0, sky, bottom_z_m);
  if (!top || *top - line_z < 2 * kWallMargin_m + kMinWall_m) return out;
  static const std::array<Direction, kHalfPlanes> half_planes = HalfPlanes(directions);
  std::array<double, kHalfPlanes> lines_z, tops_z;
  for (size_t k = 0; k < kHalfPlanes; ++k) {
    const std::optional<Place> place = FinishLine(before, asked, half_planes[k], bottom_z_m);
    if (!place) return out;
    lines_z[k] = place->line_z_m;
    tops_z[k] = WallTop_m(asked, half_planes[k], place->line_z_m, *top);
  }
  out.in_task = true;

  std::array<double, kHalfPlanes> lean_deg{}, taken{};
  double top_radius = kReach_m;
  std::array<double, kHalfPlanes> slope{}, asked_off{};
  for (size_t k = 0; k < kHalfPlanes; ++k) {
    const Direction& d = half_planes[k];
    const double lo = lines_z[k] + kWallMargin_m, hi = tops_z[k] - kWallMargin_m;
    const std::optional<Line> wall = WallLine(is, d, lo, hi), tooth = WallLine(before, d, lo, hi);
    const std::optional<Line> wanted = WallLine(asked, d, lo, hi);
    if (!wall || !tooth || !wanted) return out;
    slope[k] = wall->slope;
    asked_off[k] = tooth->median_radius_m - wanted->median_radius_m;
    lean_deg[k] = -kDegrees * ArcTan(wall->slope);
    taken[k] = tooth->median_radius_m - wall->median_radius_m;
    if (const auto r = asked.Radius_m(d, hi)) top_radius = std::min(top_radius, *r);
  }
  out.made = true;
  // Quarters of a turn, from +x to +y.
  constexpr size_t kQuarter = kHalfPlanes / 4, kToBuccal = kQuarter, kToLingual = 3 * kQuarter;
  const size_t to_mesial = mesial_x > 0 ? 0 : 2 * kQuarter, to_distal = 2 * kQuarter - to_mesial;
  std::array<double, kSections> section;
  for (size_t k = 0; k < section.size(); ++k) section[k] = lean_deg[k] + lean_deg[k + kSections];
  out.least_wall = 1;
  for (size_t side : {size_t{0}, kToBuccal, 2 * kQuarter, kToLingual}) {
    if (asked_off[side] >= kMinReduction_m) {
      out.least_wall = std::min(out.least_wall, taken[side] / asked_off[side]);
    }
  }
  for (size_t k = 0; k < section.size(); ++k) {
    const double lo = std::max(lines_z[k], lines_z[k + kSections]);
    const double apart = (slope[k] + slope[k + kSections]) * (*top - lo);
    out.overhang_m = std::max(out.overhang_m, apart);
  }
  out.mesiodistal_deg = section[0];
  out.buccolingual_deg = section[kToBuccal];
  out.least_deg = *std::ranges::min_element(section);
  out.most_deg = *std::ranges::max_element(section);
  const double along = 0.5 * (lean_deg[to_mesial] - lean_deg[to_distal]);
  const double across = 0.5 * (lean_deg[kToBuccal] - lean_deg[kToLingual]);
  out.axis_deg = std::sqrt(along * along + across * across);
  out.wall_m = {taken[to_mesial], taken[to_distal], taken[kToBuccal], taken[kToLingual]};
  out.undercut_m2 = Undercut_m2(attempt, *axis, line_z + kWallMargin_m, *top - kWallMargin_m);
  MeasureTop(initial, *attempt.volume, *reference.volume, *axis, *top, top_radius - kWallMargin_m,
             directions, out);
  MeasureLine(before, is, asked, directions, places, out);
  constexpr int kBuccalPlace = kPlaces / 4, kLingualPlace = 3 * kPlaces / 4;
  out.bevel_buccal = MeasureBevel(is, directions, places, kBuccalPlace, sky);
  out.bevel_lingual = MeasureBevel(is, directions, places, kLingualPlace, sky);
  return out;
}

}  // namespace enamel::scoring
