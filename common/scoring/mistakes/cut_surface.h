#pragma once

#include <array>
#include <optional>
#include <vector>

#include "common/scoring/mistakes/facing_surface.h"

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
  std::vector<uint8_t> family;
  FacingSurface::Families of_family;
  // Families with a sharp edge between them.
  std::array<std::array<bool, kFamilies>, kFamilies> meets{};
  bool is_stump = false;
};

CutSurface DivideSurface(const surface::Mesh& cut, const ToothPlace& place);

}  // namespace enamel::scoring
