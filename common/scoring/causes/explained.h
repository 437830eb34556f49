#pragma once

#include <array>
#include <string_view>
#include <vector>

#include "common/scoring/causes/causes.h"

// The part of the distance between two cuts that a wall, a floor or another even patch of the
// reference explains by lying elsewhere as a whole. For causes.cpp.
namespace enamel::scoring {

// An even patch of the reference's cut: a wall or the floor of a cavity; else vertices that face
// the same way of six, at one height.
struct Patch {
  Sheet sheet;
  Part part = kNoPart;
  int facing = 0;  // which of +x, -x, +y, -y, +z, -z
  std::vector<size_t> vertices;
  double area_m2 = 0;

  bool upright() const { return facing < 4; }
};

class Explained {
 public:
  Explained(const Walls& walls, const CauseInputs& inputs);

  const std::vector<Patch>& patches() const { return patches_; }
  // How much of `distance_m`, by which the attempt's surface is deeper (left: less deep) than the
  // reference's at a point, patches within that distance explain. 0 beyond kFarthest_m.
  double At_m(const dvec3& point_m, double distance_m, bool left) const;
  // Of the reference's vertex: the patch that it is on; nullptr on none.
  const Patch* PatchOf(size_t vertex) const;

  static constexpr double kFarthest_m = 1.5e-3;

 private:
  void Assign(const Walls& walls);
  void AddPatch(std::vector<size_t> vertices, int facing);
  void Fit(Patch& patch) const;
  void Sort();
  bool Gather(const dvec3& point_m, double reach_m, bool left, std::vector<double>& most) const;

  const CauseInputs& in_;
  double voxel_m_;
  std::vector<Patch> patches_;
  std::vector<int> patch_of_;  // of each vertex of the reference; -1: none
  // Vertices on patches by cell of a grid.
  static constexpr double kCell_m = 0.25e-3;
  dvec3 lo_m_{0};
  ivec3 size_{0};
  std::vector<uint32_t> first_, items_;
};

}  // namespace enamel::scoring
