#pragma once

#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "common/base/result.h"
#include "common/core/params.h"
#include "common/cutting/volume.h"
#include "common/scene/types.h"
#include "station/devices/mistakes.h"
#include "station/devices/simulated_device.h"

// The station's simulated people, and the simulated device they hold.
namespace enamel::station {

struct OperatorPreset {
  std::string_view name;  // as on the command line
  std::string_view summary;
  // Of skill: the better cutter has the higher, and no two the same. Scores are tested against it.
  // He errs as devices/mistakes.h says. 0: a hand made for one fault, which has no place among the
  // others.
  int rank = 0;
  uint64_t seed;  // of the tremor and of the mistakes
  double speed_ratio = 1;
  double layer_m = 0.5e-3;
  double rough_push_n = 1.8;
  bool clockwise = true;
  using Extra = SideErrors;
  Extra extra{};
  double tremor_ratio = 1;  // relative to a calm hand's
  double plan_share = 1;    // he stops after this share of his moves
  bool slips = false;       // at the end the bur goes into the tooth beside the cavity
  bool offered = true;      // in the window's list; the command line has all
  // Error in his idea of each wall and the floor: different for each seed, evenly distributed up to
  // twice this, never the same way for all.
  double misjudges_m = 0;
  // The bur's upper end leans to buccal; at a stump to its steeper side, and farther than the wall.
  double askew_deg = 0;
  bool nicks_neighbour = false;
  // The tissue a tooth needs for his fault to apply; air: none.
  cutting::Tissue needs = cutting::Tissue::kAir;
};
std::span<const OperatorPreset> OperatorPresets();
// Whether `preset`'s fault can be made in this exercise: the tooth has the tissue he spoils, and a
// bur held askew is not a ball.
bool HasUseFor(const OperatorPreset& preset, const scene::Scene& scene,
               const scene::Exercise& exercise);
// nullptr when the name is unknown.
const OperatorPreset* FindOperator(std::string_view name);

// The plant that a profile describes, with counts centred as in `params`.
PlantParams PlantOf(const scene::DeviceProfile& profile, const core::CoreParams& params);

// `preset` holding the profile's device over the exercise's tooth, to cut its target. `seed` 0: the
// preset's own. Errors: kInvalidInput when a part of the target is too small for its bur or has a
// bay, or the landmark is missing.
Result<std::unique_ptr<SimulatedDevice>> MakeSimulatedDevice(
    const OperatorPreset& preset, const scene::Scene& scene, const scene::Exercise& exercise,
    const scene::DeviceProfile& profile, const core::CoreParams& params,
    const cutting::Volume& volume, uint64_t seed = 0);

}  // namespace enamel::station
