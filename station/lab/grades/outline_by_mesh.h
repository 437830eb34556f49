#pragma once

#include <vector>

#include "common/surface/surface.h"
#include "station/lab/grades/hollow.h"

// Where a hollow meets a tooth's surface, and the distance of another hollow's outline from it.
// Uses the triangles of the uncut tooth, and so a different method than scoring's own (shape.h),
// which uses the surfaces of cut teeth. Thread safety: functions, any thread. Not real-time.
namespace enamel::station::lab {

struct OutlinePiece {
  dvec3 middle_m{0};
  double length_m = 0;
};
// Without neighbours. `tooth`: the surface of the uncut tooth.
std::vector<OutlinePiece> OutlineOn(const surface::Mesh& tooth, const Hollow& taken);

// The distance within which 95 % of the outline of `wanted` are from that of `made`, where `made`
// takes more; 0 where it does not.
double OutlineOver_m(const surface::Mesh& tooth, const Hollow& wanted, const Hollow& made);

}  // namespace enamel::station::lab
