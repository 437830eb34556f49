#include "station/devices/prepared_plan.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

namespace enamel::station {
namespace {

using cutting::Volume;

constexpr double kOverAll_m = 1.0e-3;  // above the highest solid, between air and work
constexpr double kThroughAir_m_per_s = 10e-3, kRowFeed_m_per_s = 3e-3, kFineRowFeed_m_per_s = 3e-3;
constexpr double kRowStock_m = 0.12e-3;                   // left by roughing
constexpr double kWorthAVisit_m = 20e-6;                  // less above the tip is not worth a visit
constexpr double kStraight_m = 8e-6;                      // corners less off a line are left out
constexpr double kRoughPitch = 0.9, kFinishPitch = 0.25;  // of the tip's radius, from row to row
constexpr double kNone_m = -1;                            // a height below every tooth

// How much higher than its tip the bur's side is at a distance from its axis.
double Rise_m(const cutting::Bur& bur, double off_m) {
  switch (bur.shape) {
    case cutting::BurShape::kSphere:
      return bur.radius_m - std::sqrt(std::max(0.0, bur.radius_m * bur.radius_m - off_m * off_m));
    case cutting::BurShape::kCone:
      return off_m <= bur.narrow_radius_m ? 0
                                          : (off_m - bur.narrow_radius_m) /
                                                (bur.radius_m - bur.narrow_radius_m) * bur.length_m;
    default:
      return 0;
  }
}

// Values over the columns of a volume's voxels, scene heights in m.
struct Heights {
  ivec3 lo{0}, size{0};  // columns; z unused
  std::vector<double> z_m;

  double& At(int x, int y) { return z_m[static_cast<size_t>(y * size.x + x)]; }
  double At(int x, int y) const { return z_m[static_cast<size_t>(y * size.x + x)]; }
  bool Has(int x, int y) const { return x >= 0 && y >= 0 && x < size.x && y < size.y; }
};

// The highest solid of each column, linear between samples.
Heights TopsOf(const Volume& volume, const ivec3& lo, const ivec3& size) {
  Heights out{lo, size, {}};
  out.z_m.assign(static_cast<size_t>(size.x * size.y), kNone_m);
  const cutting::GridSpec& spec = volume.spec();
  for (int y = 0; y < size.y; ++y)
    for (int x = 0; x < size.x; ++x) {
      int above = cutting::kPhiLimit;
      for (int k = spec.voxels().z - 1; k >= 0; --k) {
        const int phi = volume.PhiAt({lo.x + x, lo.y + y, k});
        if (phi < 0) {
          const double part = static_cast<double>(phi) / (phi - above);
          out.At(x, y) = spec.origin_m().z + (k + part) * spec.voxel_m();
          break;
        }
        above = phi;
      }
    }
  return out;
}

class RowPlanner {
 public:
  RowPlanner(const PreparedCut& cut, const cutting::Bur& bur, const Volume& volume,
             const CavityPlanOptions& options)
      : cut_(cut), bur_(bur), options_(options), spec_(volume.spec()) {
    const double h = spec_.voxel_m();
    tip_m_ = bur.shape == cutting::BurShape::kCone ? bur.narrow_radius_m : bur.radius_m;
    const dvec3 room(bur.radius_m + h, bur.radius_m + h, 0);
    const ivec3 lo = glm::max(ivec3((cut.lo_m - room - spec_.origin_m()) / h), ivec3(0));
    const ivec3 hi =
        glm::min(ivec3((cut.hi_m + room - spec_.origin_m()) / h) + 1, spec_.voxels() - 1);
    before_ = TopsOf(volume, lo, hi - lo + 1);
    const Heights after = TopsOf(*cut.prepared, lo, hi - lo + 1);
    MakeDisc();
    solid_ = Under(before_, Rests::kOnAll);
    const Heights exact = Under(after, Rests::kOnWhatStays);
    floor_ = Under(after, Rests::kOnWhatStaysButWalls);
    // Only where material is removed: the tooth beside it must not be lowered, and a slope there is
    // not a wall.
    for (int y = 0; y < floor_.size.y; ++y)
      for (int x = 0; x < floor_.size.x; ++x) {
        const bool goes = Goes(exact, x, y);
        double& z = floor_.At(x, y);
        z = goes && solid_.At(x, y) > z + kWorthAVisit_m ? z - cut.lower_m : solid_.At(x, y);
      }
    top_m_ = *std::max_element(before_.z_m.begin(), before_.z_m.end());
  }

  std::vector<Move> Make() {
    double bottom = top_m_;
    for (int y = 0; y < floor_.size.y; ++y)
      for (int x = 0; x < floor_.size.x; ++x)
        if (solid_.At(x, y) > floor_.At(x, y) + kWorthAVisit_m)
          bottom = std::min(bottom, floor_.At(x, y));
    const int layers =
        std::max(1, static_cast<int>(std::ceil((top_m_ - bottom) / options_.layer_m)));
    const int rough = Pitch(kRoughPitch), finish = Pitch(kFinishPitch);
    for (int i = 1; i <= layers; ++i) {
      const double above = top_m_ + (bottom - top_m_) * (i - 1) / layers;
      const double z = top_m_ + (bottom - top_m_) * i / layers;
      Rows(false, rough, [&](int x, int y) -> std::optional<double> {
        const double at = std::max(z, floor_.At(x, y) + kRowStock_m);
        const bool lower = i == 1 || at < std::max(above, floor_.At(x, y) + kRowStock_m);
        return lower && solid_.At(x, y) > at + kWorthAVisit_m ? std::optional(at) : std::nullopt;
      });
    }
    feed_m_per_s_ = kFineRowFeed_m_per_s;
    push_n_ = options_.finish_push_n;
    for (const bool across : {false, true}) {
      Rows(across, finish, [&](int x, int y) -> std::optional<double> {
        const double at = floor_.At(x, y);
        return solid_.At(x, y) > at + kWorthAVisit_m ? std::optional(at) : std::nullopt;
      });
    }
    Leave();
    return std::move(moves_);
  }

 private:
  struct Offset {
    int x, y;
    double rise_m;   // of the bur's side there
    double reach_m;  // from its axis
    glm::dvec2 outward;
  };

  void MakeDisc() {
    const int n = static_cast<int>(bur_.radius_m / spec_.voxel_m());
    for (int y = -n; y <= n; ++y)
      for (int x = -n; x <= n; ++x) {
        const double d = std::sqrt(x * x + y * y) * spec_.voxel_m();
        if (d > bur_.radius_m) continue;
        const glm::dvec2 outward = d > 0 ? glm::dvec2(x, y) * (spec_.voxel_m() / d) : glm::dvec2(0);
        disc_.push_back({x, y, Rise_m(bur_, d), d, outward});
      }
  }

  enum class Rests { kOnAll, kOnWhatStays, kOnWhatStaysButWalls };

  // Whether the bur has work here, or where a wall starts that goes in to here.
  bool Goes(const Heights& exact, int x, int y) const {
    for (const Offset& o : disc_) {
      if (o.reach_m > cut_.deeper_m(o.outward) && o.reach_m > 0) continue;
      const int from_x = x - o.x, from_y = y - o.y;
      if (exact.Has(from_x, from_y) &&
          solid_.At(from_x, from_y) > exact.At(from_x, from_y) + kWorthAVisit_m) {
        return true;
      }
    }
    return false;
  }

  // Height of the tip when the bur rests on the columns: on all, on those that stay, or on those
  // less the inward error of the walls.
  Heights Under(const Heights& tops, Rests rests) const {
    Heights out = tops;
    for (int y = 0; y < tops.size.y; ++y)
      for (int x = 0; x < tops.size.x; ++x) {
        double z = rests == Rests::kOnAll ? kNone_m : cut_.lo_m.z;
        for (const Offset& o : disc_) {
          if (!tops.Has(x + o.x, y + o.y)) continue;
          if (rests == Rests::kOnWhatStaysButWalls &&
              o.reach_m > bur_.radius_m - cut_.deeper_m(o.outward)) {
            continue;
          }
          z = std::max(z, tops.At(x + o.x, y + o.y) - o.rise_m);
        }
        out.At(x, y) = z;
      }
    return out;
  }

  int Pitch(double share) const {
    return std::max(1, static_cast<int>(share * tip_m_ / spec_.voxel_m()));
  }

  template <typename HeightAt>
  void Rows(bool across, int pitch, HeightAt height_at) {
    const int rows = across ? floor_.size.x : floor_.size.y,
              count = across ? floor_.size.y : floor_.size.x;
    bool forward = !options_.clockwise;
    for (int row = 0; row < rows; row += pitch) {
      std::vector<dvec3> way;
      for (int i = 0; i < count; ++i) {
        const int along = forward ? i : count - 1 - i;
        const int x = across ? row : along, y = across ? along : row;
        if (const std::optional<double> z = height_at(x, y)) {
          way.push_back(PointAt(x, y, *z));
        } else {
          Take(way);
        }
      }
      Take(way);
      forward = !forward;
    }
  }

  dvec3 PointAt(int x, int y, double z) const {
    const dvec3 p = spec_.origin_m() + dvec3(floor_.lo.x + x, floor_.lo.y + y, 0) * spec_.voxel_m();
    return {p.x, p.y, z};
  }

  // Takes one stretch of a row, without superfluous corners.
  void Take(std::vector<dvec3>& way) {
    if (way.empty()) return;
    std::vector<dvec3> corners = {way.front()};
    Simplify(way, 0, way.size() - 1, corners);
    const bool near = !moves_.empty() && glm::length(corners.front() - at_) < 2.5 * tip_m_ &&
                      corners.front().z <= at_.z + kRowStock_m &&
                      at_.z <= corners.front().z + kRowStock_m;
    if (!near) {
      const dvec3& p = corners.front();
      std::vector<dvec3> air;
      if (!moves_.empty()) air.emplace_back(at_.x, at_.y, top_m_ + kOverAll_m);
      air.emplace_back(p.x, p.y, top_m_ + kOverAll_m);
      Go(std::move(air), kThroughAir_m_per_s, 0.5, 2e-4, false);
      Go({p}, feed_m_per_s_, 0.5, 1e-4, true);
    }
    Go(std::move(corners), feed_m_per_s_, push_n_, 0.5e-4, true);
    way.clear();
  }

  // Douglas and Peucker, Cartographica 10(2), 1973.
  void Simplify(const std::vector<dvec3>& way, size_t from, size_t to,
                std::vector<dvec3>& out) const {
    size_t farthest = from;
    double most = kStraight_m;
    const dvec3 along = way[to] - way[from];
    const double length2 = glm::dot(along, along);
    for (size_t i = from + 1; i < to; ++i) {
      const dvec3 d = way[i] - way[from];
      const double t = length2 > 0 ? glm::dot(d, along) / length2 : 0;
      const double off = glm::length(d - along * t);
      if (off > most) most = off, farthest = i;
    }
    if (farthest != from) {
      Simplify(way, from, farthest, out);
      Simplify(way, farthest, to, out);
    } else if (to != from) {
      out.push_back(way[to]);
    }
  }

  void Go(std::vector<dvec3> points, double feed, double push, double tolerance, bool bur_on) {
    at_ = points.back();
    moves_.emplace_back(
        Stroke{std::move(points), feed * options_.speed_ratio, push, tolerance, bur_on});
  }
  void Leave() {
    if (moves_.empty()) return;
    Go({dvec3(at_.x, at_.y, top_m_ + kOverAll_m)}, kThroughAir_m_per_s, 0.5, 3e-4, true);
  }

  const PreparedCut& cut_;
  const cutting::Bur& bur_;
  const CavityPlanOptions& options_;
  const cutting::GridSpec& spec_;
  double tip_m_ = 0, top_m_ = 0;
  double feed_m_per_s_ = kRowFeed_m_per_s, push_n_ = 2;
  std::vector<Offset> disc_;
  Heights before_, floor_, solid_;
  dvec3 at_{0};
  std::vector<Move> moves_;
};

}  // namespace

std::vector<Move> PlanPrepared(const PreparedCut& cut, const cutting::Bur& bur,
                               const Volume& volume, const CavityPlanOptions& options) {
  return RowPlanner(cut, bur, volume, options).Make();
}

}  // namespace enamel::station
