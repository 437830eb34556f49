#pragma once

#include <vector>

#include "common/scoring/mistakes/explanation.h"

// Motions that belong together: one mistake each. Private to mistakes.cpp and naming.cpp.
namespace enamel::scoring {

// To one side of a line, a strip, or a bump: not of a whole region.
bool IsLocal(const Displacement& motion);

struct MotionGroup {
  std::vector<const Displacement*> motions;  // the first names it
  std::vector<double> d_mm;   // by piece: what they explain together, over line angles too
  std::vector<double> sizes;  // of the motions, fitted anew

  void Take(const Displacement& motion);
  bool Has(MotionKind kind) const;
  double SizeOf(MotionKind kind) const;  // 0 where there is none
};

// `motions` outlive the result. `off_mm`: Deviation_mm.
std::vector<MotionGroup> GroupMotions(const AcceptableCut& r,
                                      const std::vector<Displacement>& motions,
                                      const std::vector<double>& off_mm);

}  // namespace enamel::scoring
