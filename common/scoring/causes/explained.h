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
  dvec3 middle_m{0};
  double t_least_m = 0, t_most_m = 0;  // as far as it goes along `sheet.along`

  bool upright() const { return facing < 4; }
};

struct Explanation {
  double by_m = 0;
  const Patch* most = nullptr;  // the patch that explains most of it
  const Patch* wall = nullptr;  // the wall or floor that alone explains over half of the distance
};

class Explained {
 public:
  Explained(const Walls& walls, const CauseInputs& inputs);

  const std::vector<Patch>& patches() const { return patches_; }
  // How much of `distance_m`, by which the attempt's surface is deeper (left: less deep) than the
  // reference's at a point, patches within that distance explain, and the patches behind the
  // point by the cosine of the angle to `normal` (0: unknown). On a thin stump the side that was cut too
  // far is not the nearest one. 0 beyond kFarthest_m.
  Explanation At(const dvec3& point_m, const dvec3& normal, double distance_m, bool left) const;

  static constexpr double kFarthest_m = 1.5e-3;

 private:
  void Assign(const Walls& walls);
  void Join(const std::vector<size_t>& beside, Patch& patch);
  void AddPatch(std::vector<size_t> vertices, int facing);
  void Fit(Patch& patch) const;
  void Measure(Patch& patch) const;
  void Sort();
  void Behind(const dvec3& point_m, const dvec3& normal, bool left,
              std::vector<double>& most) const;
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
