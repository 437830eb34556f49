#pragma once

#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "common/base/result.h"
#include "common/core/params.h"
#include "common/cutting/volume.h"
#include "common/scene/types.h"
#include "station/devices/simulated_device.h"

// The simulated people a station knows, and the simulated device they hold.
namespace enamel::station {

struct OperatorPreset {
  std::string_view name;  // as on the command line
  std::string_view summary;
  double mesial_extra_m;  // how much too far the mesial wall is cut
  uint64_t seed;          // of the tremor
  double speed_ratio;
  double layer_m;
  double rough_push_n;
  bool clockwise;
};
std::span<const OperatorPreset> OperatorPresets();
// nullptr when the name is unknown.
const OperatorPreset* FindOperator(std::string_view name);

// The plant a profile describes, with counts centred as `params` say.
PlantParams PlantOf(const scene::DeviceProfile& profile, const core::CoreParams& params);

// `preset` holding the profile's device over the exercise's tooth. `seed` 0: the preset's own.
// Errors: kInvalidInput when the exercise's box is too small for its bur, or the landmark is
// missing.
Result<std::unique_ptr<SimulatedDevice>> MakeSimulatedDevice(
    const OperatorPreset& preset, const scene::Scene& scene, const scene::Exercise& exercise,
    const scene::DeviceProfile& profile, const core::CoreParams& params,
    const cutting::Volume& volume, uint64_t seed = 0);

}  // namespace enamel::station
