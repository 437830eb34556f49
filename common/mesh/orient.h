#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "common/mesh/triangles.h"

namespace enamel::mesh {

// The orientation of a crown in its file.
struct Stance {
  dvec3 up{0, 0, 1};  // occlusal, unit
  // Direction of the gum side's middle normal (away from the tooth), where one was recognised:
  // crowns cut from a scan are closed there by a smooth patch.
  std::optional<dvec3> gum;
  bool certain = true;
  double margin = 1;  // by how much `up` beats the next direction, 0 to about 1
};

// "+x", "-x", ... as typed by a person. Errors: kInvalidInput.
Result<dvec3> ParseAxis(std::string_view text);

// Finds the occlusal direction. The evidence is hollows: how deep the surface is within its convex
// hull, and which way those places face. Fossae face occlusally, a front tooth's lingual hollow
// about half-way. Smoothness alone does not suffice: the gum patch and the labial face of a front
// tooth are equally smooth. `up` is a file axis, since a gum line's plane leans up to 40 degrees
// against the long axis; y is favoured by 0.3 of the whole evidence. The patch's own direction is
// taken only where a smooth patch is right across from the hollows and more than 28 degrees from
// every axis: the crown is then askew in its file. Without hollows (spheres) the rougher end of y
// is up. `certain` from a margin of 0.2. Requires: a closed mesh oriented outward, millimetres.
Stance FindStance(const Triangles& mesh);
// With the up axis given: searches for the gum patch only.
Stance StanceWithUp(const Triangles& mesh, const dvec3& up);

// Rows are the scene's axes in the file's frame, right-handed: z = up; x and y are the two
// directions square to it that lean least against the file's axes, the longer one x or y. Which
// ends are mesial and buccal is not known from a mesh.
dmat3 SceneFromFile(const Triangles& mesh, const dvec3& up, bool longer_along_x);
// The same with y as near to `buccal` as can be. Requires: it is not along `up`.
dmat3 SceneFacing(const dvec3& up, const dvec3& buccal);

}  // namespace enamel::mesh
