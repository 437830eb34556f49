#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "common/base/result.h"
#include "common/scene/types.h"

// A material says what cutting each tissue takes, as schemas/material.schema.json describes it. The functions copy it
// into a scene's tissues. A program's own is ByLoadMaterial; `enamel-lab fit-damping --material` writes what it fitted.
// Units as TissueSpec's members say. Thread safety: functions, any thread. Real-time: not safe.
namespace enamel::scene {

struct Material {
  std::string source;  // name of the file fitted, or of the material
  struct Named {
    std::string name;  // as recorded; need not be a tissue this program knows
    TissueSpec spec;   // .tissue: kAir where `name` is none
  };
  std::vector<Named> tissues;
};

// "by-load": tissue whose cutting a hand's load controls. Sources and what is chosen: each tissue's provenance.
inline constexpr std::string_view kByLoad = "by-load";
const Material& ByLoadMaterial();
// Copies ByLoadMaterial's law into each tissue of `scene` that it names.
void CutByLoad(Scene* scene);

// Strict, as json.h. Intervals and residuals are checked and not kept.
// Errors: kInvalidInput with the member's path, kVersion for a newer format.
Result<Material> MaterialFromJson(std::string_view json);
std::string ToJson(const Material& material);

// Gives `scene`'s tissues the material's law and provenance. Tissues that the material does not have stay as they are. A
// scene that changes is another scene (its hash names it). Errors (kInvalidInput, field = the
// name): a tissue of the material that `scene` does not have; then nothing is changed.
Status ApplyMaterial(const Material& material, Scene* scene);

}  // namespace enamel::scene
