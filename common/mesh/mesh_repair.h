#pragma once

#include <array>
#include <string>
#include <vector>

#include "common/mesh/triangles.h"

namespace enamel::mesh {

// The defects of a mesh and how they were repaired.
struct MeshReport {
  size_t vertices = 0, triangles = 0;    // after welding
  size_t degenerate = 0, duplicate = 0;  // triangles left out
  size_t open_edges = 0;
  size_t non_manifold_edges = 0;  // shared by more than two triangles
  size_t flipped = 0;             // triangles turned around
  size_t parts = 0;
  size_t holes_closed = 0;
  double cap_share = 0;  // area of the caps over the whole
  size_t crossing = 0;   // triangles that another one crosses
  size_t buried = 0;     // triangles wholly inside the solid: parts overlap or it crosses itself
  size_t hollows = 0;    // closed parts within another that face the other way
  double hollow_mm3 = 0;
};

struct RepairOptions {
  // Air within a closed hollow (`hollows`): filled, or kept.
  bool keep_hollows = false;
  // Caps over more of the surface than this mean that it is a sheet and no solid. Half is the least
  // a flat sheet and its cap have.
  double largest_cap_share = 0.4;
  double finest_mm = 0.01;  // pieces along lines where triangles cross (solid_boundary.h)
};

struct Solid {
  Triangles mesh;      // closed, oriented outward, vertices welded
  Triangles boundary;  // pieces of it with solid on one side only: distances are taken to these
  Triangles hollows;   // closed parts within it that faced the other way, outward
  // Triangles of the mesh with this or a later vertex close holes; the others are the file's.
  size_t first_cap_vertex = 0;
  MeshReport report;
};

// Vertices nearer than a micrometre are one; triangles that then name a vertex twice stay.
Triangles Welded(const Triangles& mesh_mm);

// Makes a closed, outward mesh of triangles in millimetres, or reports why it cannot be one. It
// welds vertices nearer than a micrometre, turns faces to agree and closes holes by flat fans.
// Parts that overlap or are nested become one solid, and so does a surface that crosses itself:
// everything it surrounds at least once, whichever way around, is inside. Time: n log n for n
// triangles, and more for those that cross others (solid_boundary.h).
Result<Solid> MakeSolid(const Triangles& mesh_mm, const RepairOptions& options = {});

// IsCap tells the triangles that close a hole. Select takes all of them, or all others.
bool IsCap(const Solid& solid, const std::array<uint32_t, 3>& triangle);
Triangles Select(const Solid& solid, bool caps);

// The report for people, one line each.
std::vector<std::string> Describe(const MeshReport& report);

}  // namespace enamel::mesh
