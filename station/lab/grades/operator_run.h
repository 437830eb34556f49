#pragma once

#include <cstdint>
#include <functional>

#include "common/base/result.h"
#include "common/core/core.h"
#include "common/cutting/volume.h"
#include "common/scene/builtin/builtin.h"
#include "common/scene/types.h"
#include "common/trace/trace.h"
#include "station/devices/operators.h"

namespace enamel::station::lab {

// A simulated person does an exercise, as fast as the machine computes. `seen` is called with each
// tick. `seed` 0: the preset's own. Returns the tooth when he has finished, or after `most_ticks`.
// Errors: MakeSimulatedDevice's, CompilePlan's.
Result<cutting::Volume> RunOperator(
    const OperatorPreset& preset, const scene::BuiltScene& built, const scene::Exercise& exercise,
    const scene::DeviceProfile& profile, uint64_t seed, uint64_t most_ticks,
    const std::function<void(const core::CoreParams&, const trace::Tick&)>& seen);

}  // namespace enamel::station::lab
