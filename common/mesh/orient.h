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
};

// "+x" ... "-z", or three numbers as "0.2,0,-1"; of length 1. Errors: kInvalidInput, field "up".
Result<dvec3> ParseDirection(std::string_view text);

// How far the surface lies within its convex hull, and which way those hollows face: fossae face
// occlusally, a front tooth's lingual hollow about half-way.
struct Hollows {
  dvec3 facing{0};   // area- and depth-weighted mean of normals; its length is how much they agree
  double depth = 0;  // mean over the surface, mm
};
Hollows HollowsOf(const Triangles& mesh);
// Where a solid tapers off to: its third moment about its middle, over its extent's third power. A
// front tooth's drifts to its edge or cusp. Requires: a closed mesh oriented outward.
dvec3 DriftOf(const Triangles& mesh);

// With the up axis given: searches for the gum patch only.
Stance StanceWithUp(const Triangles& mesh, const dvec3& up);

// Rows are the scene's axes in the file's frame, right-handed: z = up; x and y are the two
// directions square to it that lean least against the file's axes, the longer one x or y. Which
// ends are mesial and buccal is not known from a mesh.
dmat3 SceneFromFile(const Triangles& mesh, const dvec3& up, bool longer_along_x);
// The same with y as near to `buccal` as can be. Requires: it is not along `up`.
dmat3 SceneFacing(const dvec3& up, const dvec3& buccal);

}  // namespace enamel::mesh
