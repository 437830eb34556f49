#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "common/import/triangles.h"

namespace enamel::import {

// Which way a crown stands in its file.
struct Stance {
  dvec3 up{0, 0, 1};  // occlusal, unit
  // Direction of the gum side's middle normal (away from the tooth), where one was recognised:
  // crowns cut from a scan are closed there by a smooth patch.
  std::optional<dvec3> gum;
  bool certain = true;
};

// "+x", "-x", ... as typed by a person. Errors: kInvalidInput.
Result<dvec3> ParseAxis(std::string_view text);

// Finds the gum side as the largest smooth patch that faces one way, with a rougher side (cusps)
// opposite; up points away from it: the plane of the gum line stands about square to a tooth's long
// axis. Where that is not clear (spheres) the smoother side along the file's y axis is taken for
// the gum and `certain` is false. An incisor's labial face may pass for a gum side. Requires: a
// closed mesh oriented outward.
Stance FindStance(const Triangles& mesh);
// With the up axis given: only the gum patch is looked for.
Stance StanceWithUp(const Triangles& mesh, const dvec3& up);

// Rows are the scene's axes in the file's frame: z = up, x = the longer of two
// directions square to it that lean least against the file's axes (what is mesial is not known from
// a mesh), right-handed.
dmat3 SceneFromFile(const Triangles& mesh, const dvec3& up);

}  // namespace enamel::import
