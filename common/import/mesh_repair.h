#pragma once

#include <string>
#include <vector>

#include "common/import/triangles.h"

namespace enamel::import {

// What was found in a mesh and what was done about it.
struct MeshReport {
  size_t vertices = 0, triangles = 0;    // after welding
  size_t degenerate = 0, duplicate = 0;  // triangles left out
  size_t open_edges = 0;
  size_t non_manifold_edges = 0;  // shared by more than two triangles
  size_t flipped = 0;             // triangles turned around
  size_t parts = 0;
  size_t holes_closed = 0;
  double cap_share = 0;  // area of the caps over the whole
  size_t buried = 0;     // triangles inside the solid: parts overlap or it crosses itself
};

struct Solid {
  Triangles mesh;      // closed, oriented outward, vertices welded
  Triangles boundary;  // without triangles that lie inside the solid: distances are taken to these
  MeshReport report;
};

// Makes a closed, outward mesh of triangles in millimetres, or says why it cannot be one: vertices
// nearer than a micrometre are welded, faces turned to agree, holes closed by flat fans.
// Parts that overlap or lie within each other become one solid.
Result<Solid> MakeSolid(const Triangles& mesh_mm);

// The report for people, one line each.
std::vector<std::string> Describe(const MeshReport& report);

}  // namespace enamel::import
