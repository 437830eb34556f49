#pragma once

#include <numeric>
#include <vector>

#include "common/scoring/mistakes/explanation.h"

// Motions that belong together: one mistake each. Private to mistakes.cpp and naming.cpp.
namespace enamel::scoring {

// Parts of a graph of `n` nodes.
class Components {
 public:
  explicit Components(size_t n) : parent_(n) {
    std::iota(parent_.begin(), parent_.end(), size_t{0});
  }
  size_t Of(size_t k) {
    while (parent_[k] != k) k = parent_[k] = parent_[parent_[k]];
    return k;
  }
  void Join(size_t a, size_t b) { parent_[Of(a)] = Of(b); }

 private:
  std::vector<size_t> parent_;
};

// To one side of a line, a strip, or a bump: not of a whole region.
bool IsLocal(const Displacement& motion);

struct MotionGroup {
  std::vector<const Displacement*> motions;  // the first names it
  std::vector<double> d_mm;   // by piece: what they explain together, over line angles too
  std::vector<double> sizes;  // of the motions, fitted anew

  void Take(const Displacement& motion);
  bool Has(MotionKind kind) const;
  double SizeOf(MotionKind kind) const;  // 0 where there is none
  // The wall that nearly all of it moved; -1: none.
  int OnlyWall(const AcceptableCut& r) const;
};

// `motions` outlive the result. `off_mm`: of FaultVolumes.
std::vector<MotionGroup> GroupMotions(const AcceptableCut& r, const FaultVolumes& faults,
                                      const std::vector<Displacement>& motions,
                                      const std::vector<double>& off_mm);

// How far a piece is off on one side, mm: the thickness of an even layer with its faults. Pieces of line angles have one,
// too, although off_m counts their voxels at the surfaces that meet there.
double Thickness_mm(const PieceFault& fault);

// A piece that costs, by whatever of it costs: `over`, else what was left.
struct CostlyPiece {
  uint32_t piece = 0;
  bool over = false;
  double points = 0;
};
// Bumps at the costly pieces that no motion moved: one for each connected part of one sign that costs enough to be named,
// and one for all small parts in line angles.
std::vector<Displacement> Unexplained(const AcceptableCut& r, const FaultVolumes& faults,
                                      const std::vector<MotionGroup>& groups,
                                      const std::vector<CostlyPiece>& costly);

}  // namespace enamel::scoring
