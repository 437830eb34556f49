#include "station/devices/cavity_plan.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace enamel::station {
namespace {

constexpr double kHover_m = 1.0e-3;  // above the highest solid, between air and work
constexpr double kAirFeed_m_per_s = 10e-3;
constexpr double kRoughFeed_m_per_s = 3e-3;
constexpr double kFinishFeed_m_per_s = 3e-3;
constexpr double kWallLift_m = 40e-6;    // wall passes stay this far above the floor
constexpr size_t kMaxRingSides = 100;    // of a finishing ring
constexpr double kFloorInset_m = 25e-6;  // floor passes stay this far off the walls

// Outlines that clear the outer one, innermost first: a round clears its inside up to one bur
// radius.
std::vector<Outline> Rounds(const Outline& outer, double radius) {
  std::vector<Outline> out = {outer};
  double inside = Inradius(outer);
  while (inside > 0.9 * radius) {
    // Stops before nothing is left, where sides have no direction.
    const double most = outer.size() == 4 ? inside : inside - 0.05e-3;
    out.push_back(Grown(out.back(), -std::min(1.3 * radius, most)));
    inside = Inradius(out.back());
  }
  std::reverse(out.begin(), out.end());
  return out;
}

class Planner {
 public:
  Planner(const HollowCut& hollow, const cutting::Bur& bur, const cutting::Volume& volume,
          const CavityPlanOptions& options)
      : options_(options),
        radius_(bur.radius_m),
        floor_(hollow.floor_m),
        wall_stock_(WallStock_m(hollow, bur, options)),
        tip_(Grown(hollow.walls, -radius_)) {
    ENAMEL_CHECK(wall_stock_ > 0);
    top_ = std::max(HighestSolid_m(volume, BoundsOf(hollow.walls)), floor_ + options_.layer_m);
  }

  std::vector<Move> Make() {
    Rough();
    SemiFinish();
    FinishWalls();
    FinishFloor();
    Leave();
    return std::move(moves_);
  }

 private:
  void Go(std::vector<dvec3> points, double feed, double push, double tolerance, bool bur_on) {
    if (!points.empty()) at_ = points.back();
    moves_.emplace_back(
        Stroke{std::move(points), feed * options_.speed_ratio, push, tolerance, bur_on});
  }

  void Rough() {
    std::vector<Outline> rings = Rounds(Grown(tip_, -wall_stock_), radius_);
    double bottom = floor_ + options_.floor_stock_m;
    int layers = std::max(1, static_cast<int>(std::ceil((top_ - bottom) / options_.layer_m)));
    double above = top_ + 0.2e-3;
    dvec3 entry = CornersAt(rings.front(), above, options_.clockwise).front();
    Go({dvec3(entry.x, entry.y, top_ + kHover_m)}, kAirFeed_m_per_s, 0.5, 2e-4, false);
    Go({entry}, kAirFeed_m_per_s, 0.5, 2e-4, true);
    for (int i = 1; i <= layers; ++i) {
      RoughLayer(rings, top_ + (bottom - top_) * i / layers);
    }
  }

  // Down a ramp along the innermost ring's first side, or half of many sides; then ring by ring
  // outward.
  void RoughLayer(const std::vector<Outline>& rings, double z) {
    for (size_t i = 0; i < rings.size(); ++i) {
      std::vector<dvec3> c = CornersAt(rings[i], z, options_.clockwise);
      std::vector<dvec3> way;
      const size_t ramp = c.size() > 4 ? c.size() / 2 : 1;
      if (i == 0) {
        way.push_back(dvec3(c[0].x, c[0].y, at_.z));
        for (size_t k = 1; k < ramp; ++k) {
          const double share = static_cast<double>(k) / static_cast<double>(ramp);
          way.push_back(dvec3(c[k].x, c[k].y, at_.z + share * (z - at_.z)));
        }
        way.insert(way.end(), c.begin() + static_cast<std::ptrdiff_t>(ramp), c.end());
        way.push_back(c[0]);
        way.insert(way.end(), c.begin() + 1, c.begin() + static_cast<std::ptrdiff_t>(ramp) + 1);
        if (rings.size() > 1) way.push_back(c[0]);
        Go(std::move(way), kRoughFeed_m_per_s, options_.rough_push_n, 1e-4, true);
        continue;
      }
      way.insert(way.end(), c.begin() + 1, c.end());
      way.push_back(c[0]);
      way.insert(way.begin(), c[0]);
      if (i + 1 < rings.size()) way.push_back(c[0]);
      Go(std::move(way), kRoughFeed_m_per_s, options_.rough_push_n, 1e-4, true);
    }
  }

  // The whole height of the walls at once, nearly to the line.
  void SemiFinish() {
    for (double stock : {0.5 * wall_stock_, 0.2 * wall_stock_}) {
      std::vector<dvec3> c =
          CornersAt(Grown(tip_, -stock), floor_ + kWallLift_m, options_.clockwise);
      c.push_back(c[0]);
      Go(std::move(c), kFinishFeed_m_per_s, options_.finish_push_n, 1e-4, true);
    }
  }

  void FinishWalls() {
    FinishRing ring = RingAlong(tip_, floor_ + kWallLift_m, options_.clockwise, 1);
    ring.feed_m_per_s = kFinishFeed_m_per_s * options_.speed_ratio;
    ring.push_n = 0.8;
    ring.tolerance_m = 40e-6;
    moves_.emplace_back(std::move(ring));
  }

  // Rounds as closed paths, as many together as a hand remembers; every side finishes downward.
  void FinishFloor() {
    FinishRing ring;
    for (const Outline& r : Rounds(Grown(tip_, -kFloorInset_m), radius_)) {
      std::vector<dvec3> c = CornersAt(r, floor_, options_.clockwise);
      c.push_back(c[0]);
      if (ring.corners.size() + c.size() > kMaxRingSides) AddFloor(std::exchange(ring, {}));
      ring.corners.insert(ring.corners.end(), c.begin(), c.end());
    }
    AddFloor(std::move(ring));
  }
  void AddFloor(FinishRing ring) {
    SetUpFloor(ring);
    ring.feed_m_per_s = kFinishFeed_m_per_s * options_.speed_ratio;
    moves_.emplace_back(std::move(ring));
  }

  void Leave() {
    const Bounds b = BoundsOf(tip_);
    dvec3 middle(0.5 * (b.x0 + b.x1), 0.5 * (b.y0 + b.y1), floor_ + 0.5e-3);
    Go({middle, dvec3(middle.x, middle.y, top_ + kHover_m)}, kAirFeed_m_per_s, 0.5, 3e-4, true);
  }

  const CavityPlanOptions options_;
  const double radius_, floor_, wall_stock_;
  const Outline tip_;  // where the bur's tip may be
  double top_ = 0;
  dvec3 at_{0};
  std::vector<Move> moves_;
};

}  // namespace

double HighestSolid_m(const cutting::Volume& volume, const Bounds& over) {
  const cutting::GridSpec& spec = volume.spec();
  dvec3 origin = spec.origin_m();
  double h = spec.voxel_m();
  auto index = [&](double v, double o, int limit) {
    return std::clamp(static_cast<int>(std::floor((v - o) / h)), 0, limit - 1);
  };
  ivec3 n = spec.voxels();
  for (int k = n.z - 1; k > 0; --k) {
    for (int j = index(over.y0, origin.y, n.y); j <= index(over.y1, origin.y, n.y); ++j) {
      for (int i = index(over.x0, origin.x, n.x); i <= index(over.x1, origin.x, n.x); ++i) {
        if (volume.PhiAt({i, j, k}) < 0) return origin.z + h * k;
      }
    }
  }
  return origin.z;
}

double WallStock_m(const HollowCut& hollow, const cutting::Bur& bur,
                   const CavityPlanOptions& options) {
  constexpr double kOfTheRoom = 0.6;
  return std::min(options.wall_stock_m, kOfTheRoom * (Inradius(hollow.walls) - bur.radius_m));
}

bool FitsInto(const HollowCut& hollow, double top_m, const cutting::Bur& bur,
              const CavityPlanOptions& options) {
  constexpr double kMinStock_m = 0.1e-3;
  return WallStock_m(hollow, bur, options) > kMinStock_m &&
         top_m - hollow.floor_m > options.floor_stock_m;
}

void SetUpFloor(FinishRing& ring) {
  ring.gentle = true;
  ring.tolerance_m = 0.2e-3;
  ring.accuracy_m = 7e-6;
  ring.max_passes = 6;
  ring.outward.assign(ring.corners.size(), dvec3(0, 0, -1));
  ring.push_n = 0.8;
}

FinishRing RingAlong(const Outline& outline, double z_m, bool clockwise, double outward) {
  FinishRing ring;
  ring.corners = CornersAt(outline, z_m, clockwise);
  for (size_t i = 0; i < ring.corners.size(); ++i) {
    const dvec3 along = ring.corners[(i + 1) % ring.corners.size()] - ring.corners[i];
    // To the right of a counter-clockwise path, to the left of a clockwise one.
    const double sign = (clockwise ? -1 : 1) * outward;
    ring.outward.push_back(dvec3(along.y, -along.x, 0) * (sign / std::sqrt(Dot(along, along))));
  }
  return ring;
}

std::vector<Move> PlanCavity(const HollowCut& hollow, const cutting::Bur& bur,
                             const cutting::Volume& volume, const CavityPlanOptions& options) {
  return Planner(hollow, bur, volume, options).Make();
}

}  // namespace enamel::station
