#include "common/scoring/hollow.h"

#include "common/scoring/task.h"

namespace enamel::scoring {
namespace {

surface::Mesh CutSurface(const cutting::Volume& initial, const cutting::Volume& prepared) {
  const surface::Mesh mesh = surface::ExtractSurface(prepared);
  return CutPart(mesh, CutVertices(mesh, initial, prepared));
}

}  // namespace

Hollow::Hollow(const cutting::Volume& initial, const cutting::Volume& prepared)
    : prepared_(prepared), cut_(CutSurface(initial, prepared)) {}

double Hollow::Distance_m(const dvec3& point_m, double limit_m) const {
  const double distance = cut_.Distance_m(point_m, limit_m);
  return prepared_.DistanceAt_m(point_m) < 0 ? distance : -distance;
}

}  // namespace enamel::scoring
