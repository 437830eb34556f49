#pragma once

#include <optional>
#include <string_view>
#include <vector>

#include "common/mesh/mesh_repair.h"
#include "common/mesh/orient.h"

namespace enamel::import {

// Which way a crown of a known number stands in its file, by kinds of evidence that know nothing of
// each other:
// - likeness to our own tooth of that number (likeness.h);
// - its form: the hollows of a back tooth's occlusal side, the taper of a front tooth to its edge;
// - its hole, where a scanner saw no surface: that is the gum's side.
// It is certain where two kinds agree and none contradicts. No axis of the file is favoured; one
// within 30 degrees is taken, because whoever turned a tooth upright in a program did so.
enum class Witness { kLikeness, kTaper, kHollows, kHole, kEnamel };
// "likeness", "taper", ...; kEnamel is the enamel's place on the dentin (place.h).
std::string_view WitnessName(Witness witness);

struct FoundStance {
  mesh::Stance stance;
  std::vector<Witness> by;  // the kinds that agree
};
FoundStance FindStance(const mesh::Solid& solid, int tooth);

// The unit direction in which the closed hole faces; none where the solid has only a scanner's gaps.
std::optional<dvec3> HoleOf(const mesh::Solid& solid);

}  // namespace enamel::import
