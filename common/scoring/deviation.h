#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "common/scoring/changed.h"
#include "common/scoring/zones.h"
#include "common/surface/surface.h"

// Statistics of deviations over a surface, and the parts of a cavity's surface.
namespace enamel::scoring {

struct WeightedValue {
  double value;
  double weight;
};
// The smallest value that `share` (0..1) of the weight does not exceed; 0 when there is none.
double WeightedQuantile(std::vector<WeightedValue> values, double share);

// Whether something went at a point: phi there exceeds the initial one by more than a tenth of a
// voxel.
bool IsCut(const cutting::Volume& initial, const cutting::Volume& after, const dvec3& point_m);

// The same at many points: most lie where nothing changed and are not interpolated.
class CutTest {
 public:
  // Both are kept, not copied. Requires: equal grids.
  CutTest(const cutting::Volume& initial, const cutting::Volume& after)
      : initial_(initial), after_(after), changed_(initial, after) {}
  bool At(const dvec3& point_m) const {
    return changed_.MayDifferAt(point_m) && IsCut(initial_, after_, point_m);
  }

 private:
  const cutting::Volume &initial_, &after_;
  const ChangedBricks changed_;
};

// A third of the triangles around each vertex, m^2: the area that a vertex represents.
std::vector<double> VertexAreas_m2(const surface::Mesh& mesh);

// Where the line point + s direction meets the volume's surface nearest on the side on which it
// must be: s >= 0 from a point in the solid, s <= 0 from one in the air, so that along a wall's
// outward normal s is how far the wall must still be moved to that point. +-limit_m when it is not
// met. Steps by half a voxel: a wall thinner than that may be missed.
double SurfaceAlong_m(const cutting::Volume& volume, const dvec3& point_m, const dvec3& direction,
                      double limit_m);

// Parts of a cavity. In the scene's frame buccal is +y and occlusal +z; mesial is at the end of x
// that OpenBox::mesial_x says.
enum Part : uint8_t {
  kMesial,
  kDistal,
  kBuccal,
  kLingual,
  kFloor,
  kPartCount,
  kNoPart = kPartCount
};

// Which part a point of a surface belongs to, from where it is and where the surface faces:
//  * a wall faces the box's middle within 26 degrees (cosine 0.9), is more than half the half size
//    out on its side and not beyond the box's ends along the wall;
//  * the floor faces up within 26 degrees, is below half the depth and not beyond the box's sides.
// `depth_m` is the target's depth.
Part PartOf(const OpenBox& target, double depth_m, const dvec3& point_m, const dvec3& normal);

}  // namespace enamel::scoring
