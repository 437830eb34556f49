#pragma once

#include <span>
#include <vector>

#include "station/mouth/neck.h"
#include "station/render/mesher.h"

namespace enamel::station::mouth {

// The gingiva stays at least this far below what is to be cut.
inline constexpr double kClearOfTarget_mm = 0.5;

// A papilla rises this far over where the slopes of two teeth meet.
inline constexpr double kPapilla_mm = 0.6;

// The gingiva of some teeth in a row, as a height over the plane across their axes: it rises to each
// neck's margin, falls away from it, and fills the space between two teeth with a papilla. In the
// frame of the first tooth, crown up, millimetres. Thread safety: const after construction.
class Gingiva {
 public:
  // `limit_mm`: heights around the first tooth, of what is to be cut, or more where nothing is; the
  // gingiva stays below by kClearOfTarget_mm. Requires: at least one neck.
  Gingiva(std::vector<Neck> necks, const Around& limit_mm);

  double Height_mm(double x, double y) const;
  // Its surface in pieces, to draw, of one material; and each vertex's own: attached gingiva, then
  // mucosa, then the dark of the mouth.
  std::vector<render::GroupMesh> Pieces() const;
  void Colour(render::GroupMesh& mesh) const;

 private:
  uint8_t MaterialAt(double x, double y, double z) const;

  std::vector<Neck> necks_;
  Around limit_mm_;
  double floor_mm_;
};

}  // namespace enamel::station::mouth
