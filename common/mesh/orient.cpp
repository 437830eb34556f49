#include "common/mesh/orient.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <glm/matrix.hpp>
#include <vector>

#include "common/mesh/mesh_edges.h"

namespace enamel::mesh {
namespace {

// Some 10 degrees apart: a ball of 5 mm looks about 0.04 mm hollow between them, under
// kHollowFrom_mm.
constexpr int kDirections = 400;
constexpr double kPatchCosine = 0.96;  // within 16 degrees of the patch's direction
constexpr double kMeanCosine = 0.9;
constexpr double kClearly = 1.4;
constexpr double kMinDirection = 1e-6, kMaxDirection = 1e6;  // its numbers keep their digits
constexpr double kHollowFrom_mm = 0.1;                       // the hull of kDirections is no finer

struct Facet {
  dvec3 normal{0};
  double area = 0;
  double roughness = 0;  // mean angle to its neighbours, rad
};

std::vector<Facet> FacetsOf(const Triangles& mesh) {
  std::vector<Facet> facets(mesh.indices.size());
  for (uint32_t i = 0; i < facets.size(); ++i) {
    const auto& t = mesh.indices[i];
    dvec3 n = glm::cross(mesh.vertices[t[1]] - mesh.vertices[t[0]],
                         mesh.vertices[t[2]] - mesh.vertices[t[0]]);
    double size = std::sqrt(Dot(n, n));
    facets[i].area = 0.5 * size;
    if (size > 0) facets[i].normal = n / size;
  }
  ForEachEdge(SortedEdges(mesh.indices), [&](std::span<const EdgeUse> uses) {
    if (uses.size() != 2 || uses[0].forward == uses[1].forward) return;
    Facet &l = facets[uses[0].triangle], &r = facets[uses[1].triangle];
    const double angle = std::acos(std::clamp(Dot(l.normal, r.normal), -1.0, 1.0));
    l.roughness += angle / 3;
    r.roughness += angle / 3;
  });
  return facets;
}

struct Patch {
  dvec3 direction{0};
  double area = 0;
  double roughness = 0;  // area-weighted mean
  // 0.01 rad: a flat patch must not count without bounds.
  double score() const { return area / (roughness + 0.01); }
};

Patch PatchAlong(const std::vector<Facet>& facets, const dvec3& direction, double cosine) {
  Patch p{direction, 0, 0};
  for (const Facet& f : facets) {
    if (Dot(f.normal, direction) < cosine) continue;
    p.area += f.area;
    p.roughness += f.area * f.roughness;
  }
  if (p.area > 0) p.roughness /= p.area;
  return p;
}

// Evenly spread over the sphere (Fibonacci lattice).
dvec3 Direction(int i) {
  // Equal steps of height are equal areas of a sphere; 2.39996 is the golden angle.
  double z = 1 - (2 * i + 1.0) / kDirections, r = std::sqrt(1 - z * z),
         turn = 2.399963229728653 * i;
  return {r * std::cos(turn), r * std::sin(turn), z};
}

// Area-weighted mean of the normals near a patch's direction.
dvec3 MeanNormal(const std::vector<Facet>& facets, const dvec3& direction) {
  dvec3 sum(0);
  for (const Facet& f : facets) {
    if (Dot(f.normal, direction) > kMeanCosine) sum += f.area * f.normal;
  }
  double size = std::sqrt(Dot(sum, sum));
  return size > 0 ? sum / size : direction;
}

// The best patch whose direction has at least `cosine` with `toward`.
Patch BestPatch(const std::vector<Facet>& facets, const dvec3& toward, double cosine) {
  Patch best;
  for (int i = 0; i < kDirections; ++i) {
    dvec3 d = Direction(i);
    if (Dot(d, toward) < cosine) continue;
    Patch p = PatchAlong(facets, d, kPatchCosine);
    if (p.score() > best.score()) best = p;
  }
  return best;
}

}  // namespace

Hollows HollowsOf(const Triangles& mesh) {
  const auto facets = FacetsOf(mesh);
  std::vector<bool> used(mesh.vertices.size(), false);
  for (const auto& t : mesh.indices) {
    for (uint32_t v : t) used[v] = true;
  }
  std::vector<double> along(mesh.vertices.size()), depth(mesh.vertices.size(), 1e300);
  for (int i = 0; i < kDirections; ++i) {
    const dvec3 d = Direction(i);
    double farthest = -1e300;
    for (size_t v = 0; v < along.size(); ++v) {
      along[v] = Dot(mesh.vertices[v], d);
      if (used[v]) farthest = std::max(farthest, along[v]);
    }
    for (size_t v = 0; v < along.size(); ++v) depth[v] = std::min(depth[v], farthest - along[v]);
  }
  Hollows out;
  double area = 0, sum = 0;
  for (size_t i = 0; i < facets.size(); ++i) {
    const auto& t = mesh.indices[i];
    const double below =
        std::max(0.0, (depth[t[0]] + depth[t[1]] + depth[t[2]]) / 3 - kHollowFrom_mm);
    area += facets[i].area;
    sum += facets[i].area * below;
    out.facing += facets[i].area * below * facets[i].normal;
  }
  if (sum > 0) out.facing /= sum, out.depth = sum / area;
  return out;
}

dvec3 DriftOf(const Triangles& mesh) {
  // Integrals over the solid as such over its surface, by cones from a point within: dV is a third
  // of y n dA at the surface, and a moment of order k gains a factor 3 / (k + 3).
  const dvec3 from = mesh.vertices[mesh.indices[0][0]];
  auto sum = [&](const dvec3& origin, auto moment) {
    dvec3 out(0);
    for (const auto& t : mesh.indices) {
      const dvec3 a = mesh.vertices[t[0]] - origin, b = mesh.vertices[t[1]] - origin,
                  c = mesh.vertices[t[2]] - origin;
      const dvec3 middle = (a + b + c) / 3.0;
      out += 0.5 * Dot(middle, glm::cross(b - a, c - a)) * moment(middle);
    }
    return out;
  };
  const double volume = sum(from, [](const dvec3&) { return dvec3(1); }).x / 3;
  const dvec3 middle = from + sum(from, [](const dvec3& y) { return y; }) / (4 * volume);
  const dvec3 spread = sum(middle, [](const dvec3& y) { return y * y; }) / (5 * volume);
  const dvec3 third = sum(middle, [](const dvec3& y) { return Dot(y, y) * y; }) / (6 * volume);
  return third / std::pow(spread.x + spread.y + spread.z, 1.5);
}

Result<dvec3> ParseDirection(std::string_view text) {
  if (text.size() == 2 && (text[0] == '+' || text[0] == '-') && text[1] >= 'x' && text[1] <= 'z') {
    dvec3 axis(0);
    axis[text[1] - 'x'] = text[0] == '+' ? 1 : -1;
    return axis;
  }
  dvec3 out(0);
  const char *at = text.data(), *const end = at + text.size();
  for (int k = 0; k < 3 && at != nullptr; ++k) {
    const auto read = std::from_chars(at, end, out[k]);
    const bool follows = k < 2 ? read.ptr != end && *read.ptr == ',' : read.ptr == end;
    at = read.ec == std::errc() && follows ? read.ptr + (k < 2) : nullptr;
  }
  const double length = glm::length(out);
  if (at != nullptr && length >= kMinDirection && length <= kMaxDirection) return out / length;
  return Status(Code::kInvalidInput,
                "expected a direction as +x, -x, +y, -y, +z or -z, or three numbers as 0.2,0,-1; "
                "found '" +
                    std::string(text) + "'",
                "up");
}

Stance StanceWithUp(const Triangles& mesh, const dvec3& up) {
  const auto facets = FacetsOf(mesh);
  Patch gum = BestPatch(facets, -up, 0.75);
  Patch opposite = PatchAlong(facets, up, 0.7);
  bool clear = opposite.roughness > kClearly * gum.roughness && gum.area > 0;
  return {up, clear ? std::optional<dvec3>(MeanNormal(facets, gum.direction)) : std::nullopt, true};
}

dmat3 SceneFromFile(const Triangles& mesh, const dvec3& up, bool longer_along_x) {
  dvec3 a = std::abs(up.x) < 0.7 ? dvec3(1, 0, 0) : dvec3(0, 1, 0);
  a -= Dot(a, up) * up;
  a /= std::sqrt(Dot(a, a));
  dvec3 b = glm::cross(up, a);
  auto extent = [&](const dvec3& axis) {
    double lo = 1e300, hi = -1e300;
    for (const auto& t : mesh.indices) {
      for (uint32_t i : t) {
        double s = Dot(mesh.vertices[i], axis);
        lo = std::min(lo, s), hi = std::max(hi, s);
      }
    }
    return hi - lo;
  };
  const bool first_is_longer = extent(a) >= extent(b);
  const dvec3 x = first_is_longer == longer_along_x ? a : b;
  return glm::transpose(dmat3(x, glm::cross(up, x), up));
}

dmat3 SceneFacing(const dvec3& up, const dvec3& buccal) {
  dvec3 y = buccal - Dot(buccal, up) * up;
  y /= std::sqrt(Dot(y, y));
  return glm::transpose(dmat3(glm::cross(y, up), y, up));
}

}  // namespace enamel::mesh
