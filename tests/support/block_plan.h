#pragma once

#include <cstdint>
#include <utility>

#include "common/base/check.h"
#include "common/scene/builtin/builtin.h"
#include "common/scene/plan.h"

namespace enamel::test {

// The second built-in profile with cells along the axes, recorded as they are counted: one count is one cell.
inline scene::DeviceProfile PlainProfile() {
  scene::DeviceProfile profile = scene::BuiltinProfiles()[1];
  profile.cell.reset();
  return profile;
}

// The practice block with its class I exercise, held by that profile: a core's inputs for cutting.
struct BlockPlan {
  core::CoreParams params;  // force from the first tick on
  cutting::Volume volume;
  int64_t top_nm = 0;  // the block's upper face, scene z

  // Counts along z of a tip at this height above the upper face.
  int32_t CountsAbove(int64_t above_nm) const {
    return static_cast<int32_t>((top_nm + above_nm - params.device_origin_nm[2]) /
                                params.resolution_nm[2]);
  }
};

inline BlockPlan MakeBlockPlan(int32_t voxel_nm = 200'000) {
  auto built = scene::BuildBuiltinScene("block", voxel_nm);
  ENAMEL_CHECK(built.ok());
  auto params =
      scene::CompilePlan(built->scene, scene::ClassOneExercise(built->scene, {}), PlainProfile());
  ENAMEL_CHECK(params.ok());
  params->soft_start_ticks = 1;
  const int64_t top_um = built->scene.landmarks.at("occlusal_centre")[2];
  return {*params, std::move(built->volume), top_um * 1000};
}

}  // namespace enamel::test
