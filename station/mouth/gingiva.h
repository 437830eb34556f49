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

// How high what surrounds a tooth may rise over (x, y), in the frame of its neck: kClearOfTarget_mm
// below `limit_mm`, the heights of what is to be cut around it, or more where nothing is. It may
// rise farther out.
double HighestAt_mm(const Neck& own, const Around& limit_mm, double x, double y);

// The gingiva of some teeth in a row, as a height over the plane across their axes: it rises to each
// neck's margin, falls away from it, and fills the space between two teeth with a papilla. In the
// frame of the first tooth, crown up, millimetres. Thread safety: const after construction.
class Gingiva {
 public:
  // It stays below HighestAt_mm of the first tooth. Requires: at least one neck.
  Gingiva(std::vector<Neck> necks, const Around& limit_mm);

  double Height_mm(double x, double y) const;
  // Its surface in pieces, to draw: attached gingiva, then mucosa, then the dark of the mouth.
  std::vector<render::GroupMesh> Pieces() const;

 private:
  uint8_t MaterialAt(double x, double y, double z) const;

  std::vector<Neck> necks_;
  Around limit_mm_;
  double floor_mm_;
};

}  // namespace enamel::station::mouth
