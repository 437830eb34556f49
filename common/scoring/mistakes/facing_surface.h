#pragma once

#include <array>
#include <optional>
#include <vector>

#include "common/scoring/mistakes/acceptable_cut.h"

// Which way the triangles of a cut surface face, and what they bound. Private to cut_surface.cpp. Thread safety: const
// after construction.
namespace enamel::scoring {

enum class Facing : uint8_t { kUpward, kMesial, kDistal, kBuccal, kLingual };
inline constexpr size_t kFamilies = 5;

// A smaller region is part of the line angles.
inline constexpr double kMinArea_m2 = 0.3e-6;

inline dvec3 Unit(const dvec3& v) {
  const double length = std::sqrt(Dot(v, v));
  return length > 0 ? v / length : dvec3(0, 0, 1);
}

// The triangles of `mesh` that `wanted` (of an index) accepts; none: no query.
template <typename Wanted>
std::optional<surface::DistanceQuery> QueryOf(const surface::Mesh& mesh, const Wanted& wanted) {
  surface::Mesh part = mesh;
  part.triangles.clear();
  for (size_t i = 0; i < mesh.triangles.size(); ++i) {
    if (wanted(i)) part.triangles.push_back(mesh.triangles[i]);
  }
  if (part.triangles.empty()) return {};
  return std::optional<surface::DistanceQuery>(std::in_place, part);
}

// By triangle. `cut` must outlive it.
class FacingSurface {
 public:
  FacingSurface(const surface::Mesh& cut, const ToothPlace& place);

  double MeanArea_m2() const;
  // Each family's surface, in triangles as they are.
  using Families = std::array<std::optional<surface::DistanceQuery>, kFamilies>;
  Families Surfaces() const;
  // The number of the connected upward surface that each triangle belongs to; -1 for walls.
  std::vector<int> UpwardParts(int& count) const;
  // The least area of an upward part that is a floor. `area_m2`: of each part.
  double LeastFloor_m2(const std::vector<double>& area_m2) const;

  const surface::Mesh& cut;
  const ToothPlace place;
  const int mesial_x;
  std::vector<dvec3> at_m, normal;  // normals are means over kSmooth_m
  std::vector<double> area_m2;
  std::vector<Facing> faces;
  // Surfaces that face one way: up, or to one side. All of a stump's walls are one, as its corners are round.
  std::vector<uint8_t> family;
  bool is_face = false;   // has no walls worth the name, such as a veneer
  bool is_stump = false;  // its walls face outwards
  dvec3 middle_m{0};      // of the walls

 private:
  void Smooth();
  void Classify();
  bool StandsBetweenWalls() const;
  Facing SideOf(const dvec3& n) const;
  void GiveShelvesToWalls();
};

}  // namespace enamel::scoring
