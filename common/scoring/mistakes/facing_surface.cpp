#include "common/scoring/mistakes/facing_surface.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <unordered_map>

#include "common/scene/tooth_number.h"
#include "common/scoring/mistakes/around.h"

namespace enamel::scoring {
namespace {

using enum Facing;

// Up: within 53 degrees of the way in. Walls of crowns stand steeper than 70, cusps' slopes are
// flatter than 45.
constexpr double kUp = 0.6;
// A cut that faces up to this share has no walls worth the name. Boxes have 0.27 to 0.45, a veneer 0.9.
constexpr double kFaceShare = 0.65;
// A smaller part is a shelf at the rim.
constexpr double kMinOfLargest = 0.1;
// The steps of a bur's path are finer. Chosen.
constexpr double kSmooth_m = 0.2e-3;
// Walls over from one another: pieces of this size, whose normals are 135 degrees apart and more. Chosen.
constexpr double kPatch_m = 0.4e-3, kOpposite = -0.7;

}  // namespace

FacingSurface::FacingSurface(const surface::Mesh& of, const ToothPlace& where)
    : cut(of), place(where), mesial_x(scene::MesialX(where.tooth)) {
  const size_t n = cut.triangles.size();
  at_m.resize(n), normal.resize(n), area_m2.resize(n), faces.resize(n), family.resize(n);
  for (size_t i = 0; i < n; ++i) {
    std::array<dvec3, 3> p;
    for (size_t k = 0; k < 3; ++k) p[k] = dvec3(cut.position_m[cut.triangles[i][k]]);
    const dvec3 twice = glm::cross(p[1] - p[0], p[2] - p[0]);
    at_m[i] = (p[0] + p[1] + p[2]) / 3.0;
    area_m2[i] = 0.5 * std::sqrt(Dot(twice, twice));
    normal[i] = 0.5 * twice;
  }
  Smooth();
  Classify();
  for (size_t i = 0; i < n; ++i)
    family[i] = static_cast<uint8_t>(is_stump && faces[i] != kUpward ? kMesial : faces[i]);
}

double FacingSurface::MeanArea_m2() const {
  return std::accumulate(area_m2.begin(), area_m2.end(), 0.0) / static_cast<double>(area_m2.size());
}

FacingSurface::Families FacingSurface::Surfaces() const {
  Families out;
  for (size_t f = 0; f < out.size(); ++f) {
    out[f] = QueryOf(cut, [&](size_t i) { return family[i] == f; });
  }
  return out;
}

void FacingSurface::Smooth() {
  const Around around(at_m, kSmooth_m);
  std::vector<dvec3> out(at_m.size(), dvec3(0));
  for (size_t i = 0; i < at_m.size(); ++i) {
    around.Of(i, [&](uint32_t j, double weight) { out[i] += weight * normal[j]; });
    out[i] = Unit(out[i]);
  }
  normal = std::move(out);
}

void FacingSurface::Classify() {
  double up = 0, all = 0, wall = 0;
  dvec3 middle(0);
  for (size_t i = 0; i < at_m.size(); ++i) {
    all += area_m2[i];
    if (normal[i].z > kUp)
      up += area_m2[i];
    else
      middle += area_m2[i] * at_m[i], wall += area_m2[i];
  }
  is_face = up > kFaceShare * all;
  if (wall > 0) middle_m = middle / wall;
  is_stump = !is_face && StandsBetweenWalls();
  for (size_t i = 0; i < at_m.size(); ++i) {
    faces[i] = is_face || normal[i].z > kUp ? kUpward : SideOf(normal[i]);
  }
  if (!is_face && !is_stump) GiveShelvesToWalls();
}

// Pairs of wall that face opposite ways, one straight over from the other: with air between them, as in a cavity, or the
// tooth, as in a stump. A mesio-occluso-distal cavity has both, and more of the first: its axial walls face outwards.
bool FacingSurface::StandsBetweenWalls() const {
  struct Patch {
    dvec3 at_m{0}, normal{0};
    double area_m2 = 0;
  };
  std::map<Cell, Patch> cells;
  for (size_t i = 0; i < at_m.size(); ++i) {
    if (normal[i].z > kUp) continue;
    Patch& patch = cells[CellOf(at_m[i], kPatch_m)];
    patch.at_m += area_m2[i] * at_m[i];
    patch.normal += area_m2[i] * normal[i];
    patch.area_m2 += area_m2[i];
  }
  std::vector<Patch> patches;
  for (auto& [cell, patch] : cells) {
    if (!(patch.area_m2 > 0)) continue;
    patch.at_m /= patch.area_m2;
    patch.normal = Unit(patch.normal);
    patches.push_back(patch);
  }
  double air = 0, tooth = 0;
  for (size_t i = 0; i < patches.size(); ++i) {
    for (size_t j = 0; j < i; ++j) {
      const Patch &a = patches[i], &b = patches[j];
      if (Dot(a.normal, b.normal) > kOpposite) continue;
      const dvec3 way = b.at_m - a.at_m;
      const double along = Dot(way, a.normal);
      if (Dot(way, way) - along * along > kPatch_m * kPatch_m) continue;
      (along > 0 ? air : tooth) += std::min(a.area_m2, b.area_m2);
    }
  }
  return tooth > air;
}

// A cavity's wall faces away from the side that it is on.
Facing FacingSurface::SideOf(const dvec3& n) const {
  const double side = is_stump ? 1 : -1;
  if (std::fabs(n.x) >= std::fabs(n.y)) return side * mesial_x * n.x > 0 ? kMesial : kDistal;
  return side * n.y > 0 ? kBuccal : kLingual;
}

// At some places of the grid the triangles along a rim face up.
void FacingSurface::GiveShelvesToWalls() {
  int parts = 0;
  const std::vector<int> part = UpwardParts(parts);
  std::vector<double> area(static_cast<size_t>(parts));
  for (size_t i = 0; i < at_m.size(); ++i) {
    if (part[i] >= 0) area[static_cast<size_t>(part[i])] += area_m2[i];
  }
  const double least_m2 = LeastFloor_m2(area);
  for (size_t i = 0; i < at_m.size(); ++i) {
    if (part[i] >= 0 && area[static_cast<size_t>(part[i])] < least_m2) faces[i] = SideOf(normal[i]);
  }
}

double FacingSurface::LeastFloor_m2(const std::vector<double>& area) const {
  const double largest = area.empty() ? 0 : *std::ranges::max_element(area);
  return std::max(kMinArea_m2, is_stump ? 0 : kMinOfLargest * largest);
}

std::vector<int> FacingSurface::UpwardParts(int& count) const {
  std::vector<uint32_t> parent(cut.position_m.size());
  std::iota(parent.begin(), parent.end(), 0U);
  auto root = [&](uint32_t v) {
    while (parent[v] != v) v = parent[v] = parent[parent[v]];
    return v;
  };
  for (size_t i = 0; i < at_m.size(); ++i) {
    if (faces[i] != kUpward) continue;
    const auto& t = cut.triangles[i];
    parent[root(t[1])] = root(t[0]);
    parent[root(t[2])] = root(t[0]);
  }
  std::unordered_map<uint32_t, int> number;
  std::vector<int> out(at_m.size(), -1);
  for (size_t i = 0; i < at_m.size(); ++i) {
    if (faces[i] != kUpward) continue;
    out[i] = number.try_emplace(root(cut.triangles[i][0]), static_cast<int>(number.size()))
                 .first->second;
  }
  count = static_cast<int>(number.size());
  return out;
}

}  // namespace enamel::scoring
