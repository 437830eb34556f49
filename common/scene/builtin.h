#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "common/base/result.h"
#include "common/cutting/volume.h"
#include "common/scene/types.h"

namespace enamel::scene {

struct BuiltScene {
  Scene scene;               // volume hash filled in
  cutting::Volume volume;
};

// Scenes the project makes itself, no download. "molar": a lower first molar (FDI 46) with enamel,
// dentin, pulp chamber and roots; "block": a flat gypsum practice block of 20 x 20 x 10 mm.
std::vector<std::string> BuiltinSceneNames();
Result<BuiltScene> BuildBuiltinScene(std::string_view name, int32_t voxel_nm);

// The paper's three devices with the provenance of every number: omega3, phantom_desktop, bhhd3.
std::vector<DeviceProfile> BuiltinProfiles();

// Class I occlusal cavity on any scene with an "occlusal_centre" landmark.
Exercise ClassOneExercise(const Scene& scene, const Sha256& scene_hash);

// B per tissue with provenance, as used by built-in and imported scenes.
std::vector<TissueSpec> DefaultTissues(const std::vector<cutting::Tissue>& present);

}  // namespace enamel::scene
