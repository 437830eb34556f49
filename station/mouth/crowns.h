#pragma once

#include <vector>

#include "common/scene/builtin/tooth_shape.h"
#include "station/mouth/neck.h"
#include "station/render/mesher.h"

namespace enamel::station::mouth {

// A neighbour's crown, only to look at: a built-in tooth's shape, scaled to the crown's width and depth
// of its own number. In the frame of the tooth that is worked on, crown up, millimetres.
struct Crown {
  scene::ToothShape shape;
  glm::dvec2 scale{1};   // mesiodistally, buccolingually
  glm::dvec2 middle{0};  // of its axis
  double turn_rad = 0;   // about its axis

  TissueAt tissue() const;
  Neck neck() const;
  // 200 um: the picture shows about a tooth's width, ten pixels and more a voxel, but the normals are
  // smooth.
  render::GroupMesh Mesh(int32_t voxel_nm = 200'000) const;
};

// The neighbours of a tooth, two on each side where the jaw has them, on an arch through it.
// `half_mm`: how far the tooth reaches toward +x and -x. None for deciduous teeth.
std::vector<Crown> NeighboursOf(int tooth, const std::array<double, 2>& half_mm);

// A permanent tooth's own crown, then its neighbours', in its frame.
std::vector<Crown> RowOf(int tooth);

// The tooth next to it, mesially or distally, across the midline too; 0: none.
int NextTooth(int tooth, bool mesially);

}  // namespace enamel::station::mouth
