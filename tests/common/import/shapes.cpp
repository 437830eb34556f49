#include "shapes.h"

#include <cmath>
#include <numbers>

namespace enamel::import {

Triangles SphereMesh(double radius, int n, dvec3 centre) {
  Triangles m;
  const int around = 2 * n;
  for (int j = 0; j <= n; ++j) {
    for (int i = 0; i < around; ++i) {
      double polar = std::numbers::pi * j / n, turn = std::numbers::pi * 2 * i / around;
      double ring = j == 0 || j == n ? 0 : std::sin(polar);
      m.vertices.push_back(
          centre + radius * dvec3(ring * std::cos(turn), ring * std::sin(turn), std::cos(polar)));
    }
  }
  auto at = [&](int i, int j) { return static_cast<uint32_t>(j * around + i % around); };
  for (int j = 0; j < n; ++j) {
    for (int i = 0; i < around; ++i) {
      if (j > 0) m.indices.push_back({at(i, j), at(i, j + 1), at(i + 1, j)});
      if (j < n - 1) m.indices.push_back({at(i + 1, j), at(i, j + 1), at(i + 1, j + 1)});
    }
  }
  return m;
}

Triangles BoxMesh(const dvec3& lo, const dvec3& hi) {
  Triangles m;
  for (int i = 0; i < 8; ++i) {
    m.vertices.emplace_back(i & 1 ? hi.x : lo.x, i & 2 ? hi.y : lo.y, i & 4 ? hi.z : lo.z);
  }
  const uint32_t quads[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4},
                                {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
  for (const auto& q : quads) {
    m.indices.push_back({q[0], q[1], q[2]});
    m.indices.push_back({q[0], q[2], q[3]});
  }
  return m;
}

Triangles Joined(const Triangles& a, const Triangles& b) {
  Triangles out = a;
  auto shift = static_cast<uint32_t>(a.vertices.size());
  out.vertices.insert(out.vertices.end(), b.vertices.begin(), b.vertices.end());
  for (const auto& t : b.indices) out.indices.push_back({t[0] + shift, t[1] + shift, t[2] + shift});
  return out;
}

}  // namespace enamel::import
