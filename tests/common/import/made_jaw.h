#pragma once

#include <vector>

#include "common/mesh/triangles.h"

namespace enamel::import {

// A jaw as a scanner sees it: crowns made by a formula on an arch, joined by a gum in one open surface. Occlusal at +z,
// millimetres. No crown is undercut: the surface is one height over each point of the arch.
struct MadeCrown {
  dvec3 middle;                        // at the gum
  dvec3 along;                         // mesiodistal direction, unit
  double width_mm, depth_mm, high_mm;  // mesiodistal, buccolingual, over the gum
};
struct MadeJaw {
  mesh::Triangles mesh;
  std::vector<MadeCrown> crowns;
};
// `steps`: points along the arch; there are a quarter as many across.
MadeJaw MakeJaw(int crowns, int steps);

// Points around a crown, `off_mm` outside its wall, on the surface.
std::vector<dvec3> AlongGum(const MadeJaw& jaw, size_t crown, int points, double off_mm = 0.1);
// Heights of the surface, and of the gum without crowns, at a place of the arch.
double HeightAt(const MadeJaw& jaw, const dvec3& p);
double GumAt(const MadeJaw& jaw, const dvec3& p);
// How far a point lies outside a crown's outline, seen from above; below 0 within.
double Outside_mm(const MadeCrown& crown, const dvec3& p);

}  // namespace enamel::import
