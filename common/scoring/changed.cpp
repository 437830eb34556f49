#include "common/scoring/changed.h"

#include "common/base/check.h"

namespace enamel::scoring {
namespace {

using cutting::kBrickSide;
using cutting::Volume;

bool Differs(const Volume& a, const Volume& b, int brick) {
  const bool stored = a.IsStored(brick);
  // A uniform brick that was cut into is stored from then on; that alone changes no sample, but is
  // rare enough to be looked at.
  if (stored != b.IsStored(brick)) return true;
  if (!stored) return a.UniformTissue(brick) != b.UniformTissue(brick);
  return a.Phi(brick).phi != b.Phi(brick).phi;
}

}  // namespace

ChangedBricks::ChangedBricks(const Volume& initial, const Volume& after)
    : spec_(initial.spec()),
      brick_(static_cast<size_t>(spec_.brick_count())),
      cells_(brick_.size()) {
  ENAMEL_CHECK(spec_ == after.spec());
  const ivec3& n = spec_.bricks;
  for (int b = 0; b < spec_.brick_count(); ++b) {
    if (!Differs(initial, after, b)) continue;
    brick_[static_cast<size_t>(b)] = true;
    const ivec3 at(b % n.x, b / n.x % n.y, b / (n.x * n.y));
    const ivec3 from = glm::max(at - 1, ivec3(0));
    for (int z = from.z; z <= at.z; ++z)
      for (int y = from.y; y <= at.y; ++y)
        for (int x = from.x; x <= at.x; ++x)
          cells_[static_cast<size_t>(spec_.BrickIndex({x, y, z}))] = true;
  }
}

bool ChangedBricks::MayDifferAt(const dvec3& point_m) const {
  const dvec3 g = (point_m - spec_.origin_m()) / spec_.voxel_m();
  const ivec3 n = spec_.voxels();
  if (!(g.x >= 0 && g.y >= 0 && g.z >= 0 && g.x < n.x && g.y < n.y && g.z < n.z)) return true;
  const ivec3 cell(static_cast<int>(g.x), static_cast<int>(g.y), static_cast<int>(g.z));
  return cells_[static_cast<size_t>(spec_.BrickIndex(cell / kBrickSide))];
}

}  // namespace enamel::scoring
