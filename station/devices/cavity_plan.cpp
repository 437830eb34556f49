#include "station/devices/cavity_plan.h"

#include <algorithm>
#include <cmath>

namespace enamel::station {
namespace {

constexpr double kHover_m = 1.0e-3;  // above the highest solid, between air and work
constexpr double kAirFeed_m_per_s = 10e-3;
constexpr double kRoughFeed_m_per_s = 3e-3;
constexpr double kFinishFeed_m_per_s = 3e-3;
constexpr double kWallLift_m = 40e-6;    // wall passes stay this far above the floor
constexpr double kFloorInset_m = 25e-6;  // floor passes stay this far off the walls

// A level rectangle the bur's tip may be in.
struct Rect {
  double x0, x1, y0, y1;
  Rect Inset(double by) const { return {x0 + by, x1 - by, y0 + by, y1 - by}; }
  double HalfWidth() const { return 0.5 * std::min(x1 - x0, y1 - y0); }
};

std::vector<dvec3> Corners(const Rect& r, double z, bool clockwise) {
  std::vector<dvec3> out = {{r.x0, r.y0, z}, {r.x1, r.y0, z}, {r.x1, r.y1, z}, {r.x0, r.y1, z}};
  if (clockwise) std::reverse(out.begin() + 1, out.end());
  return out;
}

// Rings that clear the rectangle, innermost first: a ring clears its inside up to one bur radius.
std::vector<Rect> Rings(const Rect& outer, double radius) {
  std::vector<Rect> out = {outer};
  while (out.back().HalfWidth() > 0.9 * radius) {
    double step = std::min(1.3 * radius, out.back().HalfWidth());
    out.push_back(out.back().Inset(step));
  }
  std::reverse(out.begin(), out.end());
  return out;
}

class Planner {
 public:
  Planner(const BoxCut& box, const cutting::Bur& bur, const cutting::Volume& volume,
          const CavityPlanOptions& options)
      : options_(options), radius_(bur.radius_m), floor_(box.centre_m.z - box.depth_m) {
    const dvec3& c = box.centre_m;
    tip_ =
        Rect{c.x - box.distal_m, c.x + box.mesial_m, c.y - box.lingual_m, c.y + box.buccal_m}.Inset(
            radius_);
    ENAMEL_CHECK(tip_.HalfWidth() > options_.wall_stock_m);
    Rect opening = tip_.Inset(-radius_);
    top_ = std::max(HighestSolid_m(volume, opening.x0, opening.x1, opening.y0, opening.y1),
                    floor_ + options_.layer_m);
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
    std::vector<Rect> rings = Rings(tip_.Inset(options_.wall_stock_m), radius_);
    double bottom = floor_ + options_.floor_stock_m;
    int layers = std::max(1, static_cast<int>(std::ceil((top_ - bottom) / options_.layer_m)));
    double above = top_ + 0.2e-3;
    dvec3 entry = Corners(rings.front(), above, options_.clockwise).front();
    Go({dvec3(entry.x, entry.y, top_ + kHover_m)}, kAirFeed_m_per_s, 0.5, 2e-4, false);
    Go({entry}, kAirFeed_m_per_s, 0.5, 2e-4, true);
    for (int i = 1; i <= layers; ++i) {
      RoughLayer(rings, top_ + (bottom - top_) * i / layers);
    }
  }

  // Down a ramp along the innermost ring's first side, then ring by ring outward.
  void RoughLayer(const std::vector<Rect>& rings, double z) {
    for (size_t i = 0; i < rings.size(); ++i) {
      std::vector<dvec3> c = Corners(rings[i], z, options_.clockwise);
      std::vector<dvec3> way;
      if (i == 0) way.push_back(dvec3(c[0].x, c[0].y, at_.z));
      way.insert(way.end(), {c[1], c[2], c[3], c[0]});
      if (i == 0) way.push_back(c[1]);
      if (i > 0) way.insert(way.begin(), c[0]);
      if (i + 1 < rings.size()) way.push_back(c[0]);
      Go(std::move(way), kRoughFeed_m_per_s, options_.rough_push_n, 1e-4, true);
    }
  }

  // The whole height of the walls at once, nearly to the line.
  void SemiFinish() {
    for (double stock : {0.5 * options_.wall_stock_m, 0.2 * options_.wall_stock_m}) {
      std::vector<dvec3> c = Corners(tip_.Inset(stock), floor_ + kWallLift_m, options_.clockwise);
      Go({c[0], c[1], c[2], c[3], c[0]}, kFinishFeed_m_per_s, options_.finish_push_n, 1e-4, true);
    }
  }

  void FinishWalls() {
    FinishRing ring;
    ring.corners = Corners(tip_, floor_ + kWallLift_m, options_.clockwise);
    for (size_t i = 0; i < ring.corners.size(); ++i) {
      dvec3 along = ring.corners[(i + 1) % 4] - ring.corners[i];
      dvec3 out =
          std::fabs(along.x) > std::fabs(along.y) ? dvec3(0, along.x, 0) : dvec3(along.y, 0, 0);
      // Away from the middle: to the right of a counter-clockwise way, to the left of the other.
      double sign = (out.x != 0) != options_.clockwise ? 1 : -1;
      ring.outward.push_back(out * (sign / std::sqrt(Dot(out, out))));
    }
    ring.feed_m_per_s = kFinishFeed_m_per_s * options_.speed_ratio;
    ring.push_n = 0.8;
    ring.tolerance_m = 40e-6;
    moves_.emplace_back(std::move(ring));
  }

  // All rings as one closed way; every side finishes downward.
  void FinishFloor() {
    FinishRing ring;
    for (const Rect& r : Rings(tip_.Inset(kFloorInset_m), radius_)) {
      std::vector<dvec3> c = Corners(r, floor_, options_.clockwise);
      ring.corners.insert(ring.corners.end(), c.begin(), c.end());
      ring.corners.push_back(c[0]);
    }
    ring.gentle = true;
    ring.tolerance_m = 0.2e-3;
    ring.accuracy_m = 7e-6;
    ring.max_passes = 6;
    ring.outward.assign(ring.corners.size(), dvec3(0, 0, -1));
    ring.feed_m_per_s = kFinishFeed_m_per_s * options_.speed_ratio;
    ring.push_n = 0.8;
    moves_.emplace_back(std::move(ring));
  }

  void Leave() {
    dvec3 middle(0.5 * (tip_.x0 + tip_.x1), 0.5 * (tip_.y0 + tip_.y1), floor_ + 0.5e-3);
    Go({middle, dvec3(middle.x, middle.y, top_ + kHover_m)}, kAirFeed_m_per_s, 0.5, 3e-4, true);
  }

  const CavityPlanOptions options_;
  const double radius_, floor_;
  Rect tip_{};
  double top_ = 0;
  dvec3 at_{0};
  std::vector<Move> moves_;
};

}  // namespace

double HighestSolid_m(const cutting::Volume& volume, double x0, double x1, double y0, double y1) {
  const cutting::GridSpec& spec = volume.spec();
  dvec3 origin = spec.origin_m();
  double h = spec.voxel_m();
  auto index = [&](double v, double o, int limit) {
    return std::clamp(static_cast<int>(std::floor((v - o) / h)), 0, limit - 1);
  };
  ivec3 n = spec.voxels();
  for (int k = n.z - 1; k > 0; --k) {
    for (int j = index(y0, origin.y, n.y); j <= index(y1, origin.y, n.y); ++j) {
      for (int i = index(x0, origin.x, n.x); i <= index(x1, origin.x, n.x); ++i) {
        if (volume.PhiAt({i, j, k}) < 0) return origin.z + h * k;
      }
    }
  }
  return origin.z;
}

bool FitsInto(const BoxCut& box, const cutting::Bur& bur, const CavityPlanOptions& options) {
  double width = std::min(box.distal_m + box.mesial_m, box.lingual_m + box.buccal_m);
  return 0.5 * width - bur.radius_m > options.wall_stock_m && box.depth_m > options.floor_stock_m;
}

std::vector<Move> PlanCavity(const BoxCut& box, const cutting::Bur& bur,
                             const cutting::Volume& volume, const CavityPlanOptions& options) {
  return Planner(box, bur, volume, options).Make();
}

}  // namespace enamel::station
