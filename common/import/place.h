#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/import/layers.h"
#include "common/import/stance.h"
#include "common/mesh/mesh_repair.h"

namespace enamel::import {

// How a tooth was turned: facts, which the command and the page put into words.
struct Placement {
  enum class Up { kGiven, kFound, kGuess };

  dvec3 up{0, 0, 1}, buccal{0, 1, 0};  // the scene's z and y in the file's axes, unit
  Up up_is = Up::kGuess;
  std::vector<Witness> by;    // that agree on a direction which was not given
  bool buccal_given = false;  // else a guess: a mesh does not say which end it is
};

// A tooth turned into the scene's frame (orient.h), the middle of its crown's bounding box at the
// origin, millimetres.
struct PlacedSolid {
  mesh::Solid solid;
  std::optional<dvec3> gum;  // as in mesh::Stance, scene frame
  Placement placement;
  // A point p of the file is at turn p - middle.
  dmat3 turn{1.0};
  dvec3 middle{0};
};
struct PlacedLayers {
  LayerSolids layers;
  Placement placement;
};

// Which tooth it is, and its orientation in the file: a direction (mesh::ParseDirection), or "auto".
struct Facing {
  int tooth = 0;       // FDI number
  std::string up;      // occlusal; auto: stance.h
  std::string buccal;  // auto: along the tooth's width or across it, as such teeth are; either end
};
// Errors: kInvalidInput, field "up" or "buccal", of directions that cannot be read.
Status CheckFacing(const Facing& facing);

// Errors: kInvalidInput, field "up" or "buccal".
Result<PlacedSolid> Place(mesh::Solid solid, const Facing& facing);
// The same for surfaces per tissue. "auto" for `up` goes from the middle of the dentin to that of
// the enamel (to the file's axis where one is within 30 degrees), or by stance.h where these middles
// coincide. The crown is the enamel, or everything where there is none.
Result<PlacedLayers> Place(LayerSolids layers, const Facing& facing);

}  // namespace enamel::import
