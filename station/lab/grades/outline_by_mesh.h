#pragma once

#include <vector>

#include "common/surface/surface.h"
#include "station/lab/grades/hollow.h"

// Where a hollow meets a tooth's surface, and how far another's outline lies from it: by the
// triangles of the uncut tooth, and so in another way than scoring's own (shape.h), which goes by the
// surfaces of the cut ones.
// Thread safety: functions, any thread. Not real-time.
namespace enamel::station::lab {

struct OutlinePiece {
  dvec3 middle_m{0};
  double length_m = 0;
};
// Neighbours apart. `tooth`: the surface of the uncut tooth.
std::vector<OutlinePiece> OutlineOn(const surface::Mesh& tooth, const Hollow& taken);

// How far 95 % of the outline of `wanted` lie, at most, from that of `made`, where `made` takes more;
// 0 where it does not.
double OutlineOver_m(const surface::Mesh& tooth, const Hollow& wanted, const Hollow& made);

}  // namespace enamel::station::lab
