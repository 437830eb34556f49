#include "station/devices/relief_plan.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/scene/preparation.h"

namespace enamel::station {
namespace {

constexpr double kClear_m = 1.0e-3;  // above the highest solid, between air and work
constexpr double kAirFeed_m_per_s = 10e-3;
constexpr double kRoughFeed_m_per_s = 4e-3;
constexpr double kFinishFeed_m_per_s = 4e-3;
constexpr double kStock_m = 0.12e-3;       // left by roughing
constexpr double kRoughRows_m = 0.5e-3;    // from row to row
constexpr double kFinishRows_m = 0.25e-3;  // a ball of 1.6 mm leaves ridges of 10 um between them
constexpr double kPoints_m = 0.4e-3;       // along a row
constexpr double kLook_m = 0.02e-3;
constexpr double kWallSlope = 1.3;  // steeper than any face of a tooth that is worked on

double HalfOf(const scene::PreparationPart& part, size_t axis) {
  const auto& half = part.outline == scene::PreparationPart::Outline::kStump
                         ? part.stump.foot.half_um
                         : part.half_size_um;
  return half[axis] * 1e-6;
}

dvec3 Normalised(const dvec3& v) { return v / std::sqrt(Dot(v, v)); }

}  // namespace

ReliefTips::ReliefTips(const PartCut& cut, const cutting::Bur& bur)
    : cut_(cut),
      end_radius_m_(bur.shape == cutting::BurShape::kCone ? bur.narrow_radius_m : bur.radius_m),
      round_end_(bur.shape == cutting::BurShape::kSphere) {
  constexpr int kRings = 6, kAround = 16;
  end_.push_back({});
  for (int i = 1; i <= kRings; ++i) {
    const double r = end_radius_m_ * i / kRings;
    const double up =
        round_end_ ? end_radius_m_ - std::sqrt(std::max(0.0, end_radius_m_ * end_radius_m_ - r * r))
                   : 0;
    for (int k = 0; k < kAround; ++k) {
      const double angle = 2 * std::numbers::pi * k / kAround;
      end_.push_back({r * std::cos(angle), r * std::sin(angle), up});
    }
  }
}

double ReliefTips::Drawn(double offset_m, double half_m, const glm::dvec2& plus) const {
  const double more = cut_.deeper_m(offset_m > 0 ? plus : -plus);
  return offset_m * half_m / (half_m + more);
}

double ReliefTips::Height_m(double x_m, double y_m) const {
  const scene::PreparationPart& part = cut_.part;
  const double mx = part.top_um[0] * 1e-6, my = part.top_um[1] * 1e-6;
  const double x = mx + Drawn(x_m - mx, HalfOf(part, 0), {1, 0});
  const double y = my + Drawn(y_m - my, HalfOf(part, 1), {0, 1});
  double z = -1;
  for (const Touch& t : end_) z = std::max(z, scene::ReliefAt(part, x + t.x, y + t.y).z_m - t.z);
  return z - cut_.lower_m;
}

Bounds ReliefTips::box() const {
  const scene::PreparationPart& part = cut_.part;
  const double x = part.top_um[0] * 1e-6, y = part.top_um[1] * 1e-6;
  auto more = [&](double dx, double dy) { return cut_.deeper_m({dx, dy}); };
  return {x - HalfOf(part, 0) - more(-1, 0), x + HalfOf(part, 0) + more(1, 0),
          y - HalfOf(part, 1) - more(0, -1), y + HalfOf(part, 1) + more(0, 1)};
}

template <typename At>
void ReliefTips::Walk(double from, double to, const At& at, double& end) const {
  const double step = to > from ? kLook_m : -kLook_m;
  double before = at(from);
  end = from;
  while (std::fabs(to - end) > kLook_m) {
    const double next = at(end + step);
    if (next - before > kWallSlope * kLook_m) return;
    end += step;
    before = next;
  }
}

Bounds ReliefTips::ReachAlongX(double y_m) const {
  Bounds out = box();
  const double middle = cut_.part.top_um[0] * 1e-6;
  auto at = [&](double x) { return Height_m(x, y_m); };
  Walk(middle, out.x0, at, out.x0);
  Walk(middle, out.x1, at, out.x1);
  return out;
}

Bounds ReliefTips::ReachAlongY(double x_m) const {
  Bounds out = box();
  const double middle = cut_.part.top_um[1] * 1e-6;
  auto at = [&](double y) { return Height_m(x_m, y); };
  Walk(middle, out.y0, at, out.y0);
  Walk(middle, out.y1, at, out.y1);
  return out;
}

std::vector<std::vector<dvec3>> RowsOver(const ReliefTips& tips, const Bounds& over,
                                         double spacing_m, double raise_m, bool from_far_side) {
  std::vector<std::vector<dvec3>> out;
  const int rows = std::max(1, static_cast<int>(std::ceil((over.y1 - over.y0) / spacing_m)));
  for (int k = 0; k <= rows; ++k) {
    const double share = static_cast<double>(from_far_side ? rows - k : k) / rows;
    const double y = over.y0 + share * (over.y1 - over.y0);
    const Bounds reach = tips.ReachAlongX(y);
    const double x0 = std::max(over.x0, reach.x0), x1 = std::min(over.x1, reach.x1);
    if (!(x1 > x0)) continue;
    const int points = std::max(1, static_cast<int>(std::ceil((x1 - x0) / kPoints_m)));
    std::vector<dvec3> row;
    for (int i = 0; i <= points; ++i) {
      const double x = x0 + (x1 - x0) * i / points;
      row.emplace_back(x, y, tips.Height_m(x, y) + raise_m);
    }
    if (k % 2 != 0) std::reverse(row.begin(), row.end());
    out.push_back(std::move(row));
  }
  return out;
}

std::vector<Move> PlanRelief(const PartCut& cut, const cutting::Bur& bur,
                             const cutting::Volume& volume, const CavityPlanOptions& options) {
  const ReliefTips tips(cut, bur);
  const Bounds box = tips.box();
  const Bounds over = tips.ReachAlongY(0.5 * (box.x0 + box.x1));
  const double clear = HighestSolid_m(volume, box) + kClear_m;
  std::vector<Move> moves;
  auto go = [&](std::vector<dvec3> points, double feed, double push, bool bur_on) {
    moves.emplace_back(
        Stroke{std::move(points), feed * options.speed_ratio, push, bur_on ? 1e-4 : 2e-4, bur_on});
  };
  auto rough = RowsOver(tips, over, kRoughRows_m, kStock_m, options.clockwise);
  const dvec3 first = rough.front().front();
  go({dvec3(first.x, first.y, clear)}, kAirFeed_m_per_s, 0.5, false);
  for (auto& row : rough) go(std::move(row), kRoughFeed_m_per_s, options.rough_push_n, true);
  // In the opposite direction, so that the last rough row is beside the first of these. Two rows at
  // a time, forth and back, until they are right.
  const auto rows = RowsOver(tips, over, kFinishRows_m, 0, !options.clockwise);
  for (size_t k = 0; k < rows.size(); k += 2) {
    FinishRing ring;
    ring.corners = rows[k];
    const auto& back = rows[k + 1 < rows.size() ? k + 1 : k - 1];
    ring.corners.insert(ring.corners.end(), back.begin(), back.end());
    SetUpFloor(ring);
    for (size_t i = 0; i < ring.corners.size(); ++i) {
      const dvec3 along = ring.corners[(i + 1) % ring.corners.size()] - ring.corners[i];
      const dvec3 way = Normalised(along), down(0, 0, -1);
      ring.outward[i] = Normalised(down - way * Dot(down, way));
    }
    ring.feed_m_per_s = kFinishFeed_m_per_s * options.speed_ratio;
    moves.emplace_back(std::move(ring));
  }
  const dvec3 last = rows.back().front();
  go({dvec3(last.x, last.y, clear)}, kAirFeed_m_per_s, 0.5, true);
  return moves;
}

}  // namespace enamel::station
