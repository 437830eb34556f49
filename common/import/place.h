#pragma once

#include <optional>
#include <string>

#include "common/import/layers.h"
#include "common/mesh/mesh_repair.h"

namespace enamel::import {

// A tooth turned into the scene's frame (orient.h), the middle of its crown's bounding box at the
// origin, millimetres.
struct PlacedSolid {
  mesh::Solid solid;
  std::optional<dvec3> gum;  // as in mesh::Stance, scene frame
  std::string words;         // how it was turned, for people
};
struct PlacedLayers {
  LayerSolids layers;
  std::string words;
};

// `up`: the occlusal direction in the file, "+x" ... "-z", or "auto": found by the hollows of the
// shape. Errors: kInvalidInput, field "up".
Result<PlacedSolid> Place(mesh::Solid solid, const std::string& up);
// The same for surfaces per tissue, where "auto" goes from the middle of the dentin to that of the
// enamel (to the file's axis where one is within 30 degrees), and by hollows where these coincide.
// The crown is the enamel, or all where there is none.
Result<PlacedLayers> Place(LayerSolids layers, const std::string& up);

}  // namespace enamel::import
