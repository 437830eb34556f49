#pragma once

#include <array>
#include <optional>
#include <vector>

#include "common/scoring/mistakes/acceptable_cut.h"

// Divides the surface that an acceptable cut left into regions. Private to acceptable_cut.cpp.
namespace enamel::scoring {

inline constexpr uint32_t kNoPiece = 0xffffffff;

// The regions of a mesh, triangle by triangle.
struct CutSurface {
  std::vector<Region> regions;  // by name, the line angles last
  std::vector<SurfacePiece> pieces;
  std::vector<uint32_t> piece;  // of its region
  // Near the border with another region of the same surface: a piece of that one, and its share. Else kNoPiece and 0.
  std::vector<uint32_t> beside;
  std::vector<double> beside_share;
  std::vector<uint32_t> edge_piece;  // of the line angles, in their band; else kNoPiece
  // Surfaces that face one way: up, or to one side. All of a stump's walls are one, as its corners
  // are round.
  std::vector<uint8_t> family;
  static constexpr size_t kFamilies = 5;
  std::array<std::optional<surface::DistanceQuery>, kFamilies> of_family;
  // Families with a sharp edge between them.
  std::array<std::array<bool, kFamilies>, kFamilies> meets{};
  bool is_stump = false;
};

CutSurface DivideSurface(const surface::Mesh& cut, const ToothPlace& place);

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

}  // namespace enamel::scoring
