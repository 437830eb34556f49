#include "shapes.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace enamel::import {

mesh::Triangles SphereMesh(double radius, int n, dvec3 centre) {
  mesh::Triangles m;
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

mesh::Triangles BoxMesh(const dvec3& lo, const dvec3& hi) {
  mesh::Triangles m;
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

mesh::Triangles RevolvedMesh(const std::vector<ProfilePoint>& profile, int around, bool closed) {
  mesh::Triangles m;
  const auto n = static_cast<uint32_t>(around);
  for (const ProfilePoint& p : profile)
    for (int i = 0; i < around; ++i) {
      const double turn = 2 * std::numbers::pi * i / around;
      m.vertices.emplace_back(p.r * std::cos(turn), p.r * std::sin(turn), p.z);
    }
  const size_t rings = profile.size();
  for (size_t j = 0; j + (closed ? 0 : 1) < rings; ++j) {
    const auto lower = static_cast<uint32_t>(j) * n,
               upper = static_cast<uint32_t>((j + 1) % rings) * n;
    for (uint32_t i = 0; i < n; ++i) {
      const uint32_t k = (i + 1) % n;
      m.indices.push_back({lower + i, upper + i, upper + k});
      m.indices.push_back({lower + i, upper + k, lower + k});
    }
  }
  return m;
}

std::vector<ProfilePoint> Arc(double radius, double z, double from, double to, int steps) {
  std::vector<ProfilePoint> out;
  for (int i = 0; i <= steps; ++i) {
    const double a = from + (to - from) * i / steps;
    out.push_back({radius * std::max(0.0, std::sin(a)), z + radius * std::cos(a)});
  }
  return out;
}

mesh::Triangles Reversed(mesh::Triangles mesh) {
  for (auto& t : mesh.indices) std::swap(t[1], t[2]);
  return mesh;
}

mesh::Triangles Joined(const mesh::Triangles& a, const mesh::Triangles& b) {
  mesh::Triangles out = a;
  auto shift = static_cast<uint32_t>(a.vertices.size());
  out.vertices.insert(out.vertices.end(), b.vertices.begin(), b.vertices.end());
  for (const auto& t : b.indices) out.indices.push_back({t[0] + shift, t[1] + shift, t[2] + shift});
  return out;
}

}  // namespace enamel::import
