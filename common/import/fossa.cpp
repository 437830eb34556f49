#include "common/import/fossa.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

namespace enamel::import {
namespace {

constexpr double kFossaSearch = 0.25;  // half a side of the searched square, of the smaller width
constexpr int kFossaSteps = 20;
// Substance a class I outline needs around the centre: half sides, depths, and what must be left.
constexpr double kOutlineX_mm = 2.3, kOutlineY_mm = 1.3;
constexpr std::array<double, 2> kOutlineDepths_mm = {1, 2};
constexpr double kEnoughRoom_mm = 0.2;

using SignedDistance = std::function<double(const dvec3&)>;

// The occlusal surface seen from above.
class TopView {
 public:
  TopView(const mesh::TriangleTree& tree, const dvec3& lo, const dvec3& hi)
      : tree_(tree), lo_(lo), hi_(hi) {}
  // Height of the first surface under (x, y), mm; nothing where there is none.
  std::optional<double> Height(double x, double y) const {
    // Sphere tracing (Hart, The Visual Computer 12, 1996): nothing is nearer than d, so d is a free
    // step down. 300 are for ways that graze a wall.
    double z = hi_.z + 0.1;
    for (int i = 0; i < 300 && z > lo_.z; ++i) {
      double d = tree_.Distance({x, y, z}, 100);
      if (d < 1e-4) return z;
      z -= d;
    }
    return std::nullopt;
  }

 private:
  const mesh::TriangleTree& tree_;
  dvec3 lo_, hi_;
};

// Least distance from the outline of a class I box below `p` to the tooth's surface, mm; negative
// where the outline leaves the tooth.
double RoomAround(const dvec3& p, const SignedDistance& distance) {
  double room = 1e300;
  for (double depth : kOutlineDepths_mm)
    for (int k = 0; k < 9; ++k) {
      if (k == 4) continue;
      const dvec3 at = p + dvec3((k % 3 - 1) * kOutlineX_mm, (k / 3 - 1) * kOutlineY_mm, -depth);
      room = std::min(room, -distance(at));
    }
  return room;
}

// Heights of the occlusal surface on a square grid around its middle.
class FossaSearch {
 public:
  FossaSearch(const mesh::TriangleTree& outer, const SignedDistance& distance, const dvec3& lo,
              const dvec3& hi)
      : distance_(distance), middle_(0.5 * (lo + hi)) {
    const TopView top(outer, lo, hi);
    const dvec3 size = hi - lo;
    step_ = kFossaSearch * std::min(size.x, size.y) / kFossaSteps;
    for (int k = 0; k < kSide * kSide; ++k) {
      const dvec3 p = At(k);
      height_[static_cast<size_t>(k)] = top.Height(p.x, p.y).value_or(hi.z);
    }
    FindSlope();
  }

  // The pit nearest the middle, else the middle, as far as there is room around it; else the point
  // with most room.
  Fossa Find() const {
    constexpr int kMiddle = kSide * kSide / 2;
    int nearest = -1;
    for (int k = 0; k < kSide * kSide; ++k) {
      if (IsPit(k) && (nearest < 0 || Away(k) < Away(nearest)) && Room(k) >= kEnoughRoom_mm)
        nearest = k;
    }
    if (nearest >= 0) return {At(nearest), Centre::kPit};
    if (Room(kMiddle) >= kEnoughRoom_mm) return {At(kMiddle), Centre::kMiddle};
    int best = kMiddle;
    double most = Room(kMiddle);
    for (int k = 0; k < kSide * kSide; ++k) {
      const double room = Room(k);
      if (room > most) most = room, best = k;
    }
    return {At(best), best == kMiddle ? Centre::kMiddle : Centre::kMaxRoom};
  }

 private:
  static constexpr int kSide = 2 * kFossaSteps + 1;
  static int Column(int k) { return k % kSide - kFossaSteps; }
  static int Row(int k) { return k / kSide - kFossaSteps; }
  static int Away(int k) { return Column(k) * Column(k) + Row(k) * Row(k); }
  dvec3 At(int k) const {
    return {middle_.x + Column(k) * step_, middle_.y + Row(k) * step_,
            height_[static_cast<size_t>(k)]};
  }
  double Room(int k) const { return RoomAround(At(k), distance_); }

  void FindSlope() {
    double spread = 0;
    for (int k = 0; k < kSide * kSide; ++k) {
      // Least squares; the grid is symmetric, so the two slopes do not mix.
      slope_x_ += height_[static_cast<size_t>(k)] * Column(k);
      slope_y_ += height_[static_cast<size_t>(k)] * Row(k);
      spread += Column(k) * Column(k);
    }
    slope_x_ /= spread, slope_y_ /= spread;
  }
  // Counted from the surface's mean slope, so that a fossa on a leaning crown is a pit too.
  double Level(int k) const {
    return height_[static_cast<size_t>(k)] - slope_x_ * Column(k) - slope_y_ * Row(k);
  }
  bool IsPit(int k) const {
    if (std::abs(Column(k)) > kFossaSteps - 2 || std::abs(Row(k)) > kFossaSteps - 2) return false;
    // Lowest within two steps each way: some 0.25 mm on a molar.
    for (int i = 0; i < 25; ++i) {
      if (Level(k + i % 5 - 2 + (i / 5 - 2) * kSide) < Level(k)) return false;
    }
    return true;
  }

  const SignedDistance& distance_;
  dvec3 middle_;
  double step_ = 0, slope_x_ = 0, slope_y_ = 0;
  std::array<double, kSide * kSide> height_{};
};

}  // namespace

const char* Words(Centre kind) {
  switch (kind) {
    case Centre::kPit:
      return "bottom of the pit nearest the middle";
    case Centre::kMiddle:
      return "middle of the occlusal surface, there is no pit near it";
    case Centre::kMaxRoom:
      return "where a class I outline has most room, it has little everywhere";
  }
  return "";
}

Fossa FindFossa(const mesh::TriangleTree& outer, const SignedDistance& distance, const dvec3& lo,
                const dvec3& hi) {
  return FossaSearch(outer, distance, lo, hi).Find();
}

}  // namespace enamel::import
