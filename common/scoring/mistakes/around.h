#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include "common/math/vec.h"

// Finds the points near another. Private to cut_surface.cpp.
// Thread safety: const after construction. Not real-time.
namespace enamel::scoring {

using Cell = std::array<int32_t, 3>;
inline Cell CellOf(const dvec3& p, double size_m) {
  const dvec3 g = p / size_m;
  return {static_cast<int32_t>(std::floor(g.x)), static_cast<int32_t>(std::floor(g.y)),
          static_cast<int32_t>(std::floor(g.z))};
}
struct CellHash {
  size_t operator()(const Cell& c) const {
    return (static_cast<size_t>(static_cast<uint32_t>(c[0])) * 73856093U) ^
           (static_cast<size_t>(static_cast<uint32_t>(c[1])) * 19349663U) ^
           (static_cast<size_t>(static_cast<uint32_t>(c[2])) * 83492791U);
  }
};

// Points sorted into cells of one radius, to find those near another.
class Around {
 public:
  Around(const std::vector<dvec3>& at_m, double radius_m) : at_m_(at_m), radius_m_(radius_m) {
    for (size_t i = 0; i < at_m.size(); ++i) {
      cells_[CellOf(at_m[i], radius_m)].push_back(static_cast<uint32_t>(i));
    }
  }
  // Calls visit(j, weight) for each point within the radius of point i, itself too: weight is 1 at point i and falls to 0
  // at the radius.
  template <typename Visit>
  void Of(size_t i, const Visit& visit) const {
    const Cell c = CellOf(at_m_[i], radius_m_);
    for (int k = 0; k < 27; ++k) {
      const auto cell = cells_.find({c[0] + k % 3 - 1, c[1] + k / 3 % 3 - 1, c[2] + k / 9 - 1});
      if (cell == cells_.end()) continue;
      for (const uint32_t j : cell->second) {
        const dvec3 way = at_m_[j] - at_m_[i];
        const double in = 1 - Dot(way, way) / (radius_m_ * radius_m_);
        if (in >= 0) visit(j, in * in);
      }
    }
  }

 private:
  const std::vector<dvec3>& at_m_;
  const double radius_m_;
  std::unordered_map<Cell, std::vector<uint32_t>, CellHash> cells_;
};

}  // namespace enamel::scoring
