#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/import/layers.h"
#include "common/mesh/mesh_repair.h"

namespace enamel::import {

// A tooth turned into the scene's frame (orient.h), the middle of its crown's bounding box at the
// origin, millimetres.
struct PlacedSolid {
  mesh::Solid solid;
  std::optional<dvec3> gum;        // as in mesh::Stance, scene frame
  std::vector<std::string> words;  // how it was turned, for people
};
struct PlacedLayers {
  LayerSolids layers;
  std::vector<std::string> words;
};

// Which tooth it is, and its orientation in the file: "+x" ... "-z", or "auto".
struct Facing {
  int tooth = 0;       // FDI number
  std::string up;      // occlusal; auto: stance.h
  std::string buccal;  // auto: along the tooth's width or across it, as such teeth are; either end
};

// Errors: kInvalidInput, field "up" or "buccal".
Result<PlacedSolid> Place(mesh::Solid solid, const Facing& facing);
// The same for surfaces per tissue. "auto" for `up` goes from the middle of the dentin to that of
// the enamel (to the file's axis where one is within 30 degrees), or by stance.h where these middles
// coincide. The crown is the enamel, or everything where there is none.
Result<PlacedLayers> Place(LayerSolids layers, const Facing& facing);

}  // namespace enamel::import
