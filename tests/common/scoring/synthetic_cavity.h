#pragma once

#include "common/core/params.h"
#include "common/cutting/volume.h"
#include "common/scene/types.h"
#include "common/scoring/metrics.h"

// A flat block and box cavities cut into it with a turning cylinder, where every metric has a
// closed form.
namespace enamel::scoring {

// Top of the block at z = 0, 7 x 6 mm wide, 4 mm deep, of enamel down to 1.2 mm, dentin below,
// pulp below 2.8 mm. The grid does not line up with any of it; it may be moved up.
cutting::Volume MakeBlock(int32_t voxel_nm, int64_t up_nm = 0);

struct Cavity {
  double mesial_mm = 1.5, distal_mm = 1.5;   // walls at +x, -x from the middle
  double buccal_mm = 1.2, lingual_mm = 1.2;  // +y, -y
  double depth_mm = 2;
  double turn = 0;  // about the block's axis: tangent of half the angle
  double tilt = 0;  // of the bur about x: tangent of half the angle
};
inline constexpr double kBurRadius_mm = 0.5;

// Cut with poses half a voxel apart.
cutting::Volume CutCavity(const cutting::Volume& block, const Cavity& cavity);

// Scene and exercise whose target is the cavity as given by default above.
scene::Scene BlockScene();
scene::Exercise BlockExercise();

core::CoreParams SomeParams();
// A recording of `ticks` ticks that moves at `speed_mm_per_s` along x with a constant force.
ProcessRecorder StraightRecording(uint32_t ticks, double speed_mm_per_s, double force_n);

// One side of a comparison, with its surface.
struct Cut {
  cutting::Volume volume;
  surface::Mesh mesh;
  ProcessRecorder process;

  Cut(const cutting::Volume& block, const Cavity& cavity);
  AttemptData Data(const cutting::Volume& block) const {
    return {&block, &volume, &mesh, &process};
  }
};

// NaN, and a failed expectation, where it has none.
double ValueOf(const MetricSet& metrics, std::string_view name);

}  // namespace enamel::scoring
