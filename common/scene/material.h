#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "common/base/result.h"
#include "common/scene/types.h"

// A material profile as schemas/material.schema.json has it (written by `enamel-station
// fit-damping --material`), and the way of its numbers into a scene's tissues.
// Units as the members say: mN s/mm, mN. Thread safety: functions, any thread. Real-time: not safe.
namespace enamel::scene {

struct Material {
  std::string source;    // name of the file fitted
  int64_t rate_mhz = 0;  // median rate of its samples, 1e-3 Hz
  struct Fitted {
    std::string name;  // as recorded; need not be a tissue this program knows
    TissueSpec spec;   // .tissue: kAir where `name` is none
  };
  std::vector<Fitted> tissues;
};

// Strict, as json.h. Intervals and residuals are checked and not kept.
// Errors: kInvalidInput with the member's path, kVersion for a newer format.
Result<Material> MaterialFromJson(std::string_view json);

// Gives `scene`'s tissues what was measured: damping, along the bur where the profile has it,
// Coulomb part, threshold and provenance. Tissues the profile does not have stay as they are. A
// scene that changes is another scene (its hash names it). Errors (kInvalidInput, field = the
// name): a profile tissue that `scene` does not have; then nothing is changed.
Status ApplyMaterial(const Material& material, Scene* scene);

}  // namespace enamel::scene
