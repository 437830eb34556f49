#pragma once

#include <optional>
#include <string>

#include "common/base/result.h"
#include "common/core/params.h"
#include "common/cutting/volume.h"
#include "common/scene/types.h"

namespace enamel::scene {

// Compiles scene, exercise and device profile into the core's parameters: the only way an attempt
// gets them, on the station; the server re-derives them and compares with the attempt's header. The
// device's counts are centred above the exercise's landmark: count (0, 0, 0) is the bur's tip 8 mm
// above it (scene frame, +z), clear of every cusp; the axes of device and scene agree. Force and
// cutting begin after half a second in free air. The coupling's stiffness at half its height
// resists a turn of the bur, felt or not: a device that cannot push back must not cut by turning.
// The motors are asked for less force by the device's friction, or by a share of one that nobody measured
// (own_friction.h). Touch cues are the exercise's, whether it is graded or not; an exercise that names none has none.
// An exercise whose scene hash is not zero is compiled with that scene only (kConflict). Errors:
// kInvalidInput when the profile cannot carry the exercise (rate, touch cues under 300 Hz, Kc above
// what its damping, friction, structure or first resonance carries (rate.h), a missing landmark or tissue,
// a bur that the scene does not offer), with the allowed value.
Result<core::CoreParams> CompilePlan(const Scene& scene, const Exercise& exercise,
                                     const DeviceProfile& profile);

// cutting::WhyTooCoarse of the first of the exercise's burs for which these voxels are.
std::optional<std::string> WhyTooCoarse(const Exercise& exercise, int32_t voxel_nm);

// Refuses a volume that is not what the scene says: another voxel size, a tissue the scene does not
// name (it would have no damping), a tissue it names that is nowhere. Errors: kConflict.
Status CheckVolume(const Scene& scene, const cutting::Volume& volume);

}  // namespace enamel::scene
