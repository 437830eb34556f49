#include "common/import/orient.h"

#include <algorithm>
#include <cmath>
#include <glm/matrix.hpp>
#include <map>
#include <vector>

namespace enamel::import {
namespace {

constexpr int kDirections = 400;
constexpr double kPatchCosine = 0.96;  // within 16 degrees of the patch's direction
constexpr double kMeanCosine = 0.9;
constexpr double kElsewhereCosine = 0.5;  // another patch: 60 degrees away or more
constexpr double kClearly = 1.4;

struct Facet {
  dvec3 normal{0};
  double area = 0;
  double roughness = 0;  // mean angle to its neighbours, rad
};

std::vector<Facet> FacetsOf(const Triangles& mesh) {
  std::vector<Facet> facets(mesh.indices.size());
  std::map<std::pair<uint32_t, uint32_t>, uint32_t> owner;
  for (uint32_t i = 0; i < facets.size(); ++i) {
    const auto& t = mesh.indices[i];
    dvec3 n = glm::cross(mesh.vertices[t[1]] - mesh.vertices[t[0]],
                         mesh.vertices[t[2]] - mesh.vertices[t[0]]);
    double size = std::sqrt(Dot(n, n));
    facets[i].area = 0.5 * size;
    if (size > 0) facets[i].normal = n / size;
    for (size_t k = 0; k < 3; ++k) owner[{t[k], t[(k + 1) % 3]}] = i;
  }
  for (uint32_t i = 0; i < facets.size(); ++i) {
    const auto& t = mesh.indices[i];
    for (size_t k = 0; k < 3; ++k) {
      auto other = owner.find({t[(k + 1) % 3], t[k]});
      if (other == owner.end()) continue;
      double c = std::clamp(Dot(facets[i].normal, facets[other->second].normal), -1.0, 1.0);
      facets[i].roughness += std::acos(c) / 3;
    }
  }
  return facets;
}

struct Patch {
  dvec3 direction{0};
  double area = 0;
  double roughness = 0;  // area-weighted mean
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

Patch BestPatchElsewhere(const std::vector<Facet>& facets, const dvec3& from) {
  Patch best;
  for (int i = 0; i < kDirections; ++i) {
    dvec3 d = Direction(i);
    if (Dot(d, from) > kElsewhereCosine) continue;
    Patch p = PatchAlong(facets, d, kPatchCosine);
    if (p.score() > best.score()) best = p;
  }
  return best;
}

}  // namespace

Result<dvec3> ParseAxis(std::string_view text) {
  if (text.size() == 2 && (text[0] == '+' || text[0] == '-') && text[1] >= 'x' && text[1] <= 'z') {
    dvec3 axis(0);
    axis[text[1] - 'x'] = text[0] == '+' ? 1 : -1;
    return axis;
  }
  return Status(Code::kInvalidInput,
                "expected the occlusal direction as +x, -x, +y, -y, +z or -z, found '" +
                    std::string(text) + "'",
                "up");
}

Stance FindStance(const Triangles& mesh) {
  const auto facets = FacetsOf(mesh);
  Patch gum = BestPatch(facets, {0, 0, 1}, -2);
  Patch rival = BestPatchElsewhere(facets, gum.direction);
  Patch opposite = PatchAlong(facets, -gum.direction, 0.7);
  if (gum.score() > kClearly * rival.score() && opposite.roughness > kClearly * gum.roughness) {
    dvec3 mean = MeanNormal(facets, gum.direction);
    return {-mean, mean, true};
  }
  Patch above = PatchAlong(facets, {0, 1, 0}, 0.7), below = PatchAlong(facets, {0, -1, 0}, 0.7);
  dvec3 up(0, above.roughness > below.roughness ? 1 : -1, 0);
  return {up, std::nullopt, false};
}

Stance StanceWithUp(const Triangles& mesh, const dvec3& up) {
  const auto facets = FacetsOf(mesh);
  Patch gum = BestPatch(facets, -up, 0.75);
  Patch opposite = PatchAlong(facets, up, 0.7);
  bool clear = opposite.roughness > kClearly * gum.roughness && gum.area > 0;
  return {up, clear ? std::optional<dvec3>(MeanNormal(facets, gum.direction)) : std::nullopt, true};
}

dmat3 SceneFromFile(const Triangles& mesh, const dvec3& up) {
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
  dvec3 x = extent(a) >= extent(b) ? a : b;
  dvec3 y = glm::cross(up, x);
  return glm::transpose(dmat3(x, y, up));
}

}  // namespace enamel::import
