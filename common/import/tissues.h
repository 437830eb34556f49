#pragma once

#include <memory>
#include <string>
#include <vector>

#include "common/cutting/tissue.h"
#include "common/math/vec.h"
#include "common/mesh/mesh_repair.h"

namespace enamel::import {

// Tissues of a crown of which only the outside is known, by depth below its smoothed outer surface (the gum
// side does not count): enamel of a thickness that rises from 0 at the gum to its full value at the
// cusps, dentin, and a pulp chamber low in the middle. Assumptions throughout, and reported as
// such. Frame: scene axes, millimetres. Thread safety: const after construction.
class TissueModel {
 public:
  // `solid`, in the scene frame; `gum` as in Stance; `fossa_mm`: height of the occlusal centre; `tooth`: FDI
  // number, which scales what is assumed.
  TissueModel(const mesh::Solid& solid, const dvec3* gum, const dvec3& lo_mm, const dvec3& hi_mm,
              double fossa_mm, int tooth);

  struct Sample {
    cutting::Tissue tissue;
    double margin_mm;  // no other tissue nearer than this
  };
  // Requires: a point inside the crown (elsewhere the nearest guess).
  Sample At(const dvec3& p_mm) const;

  double enamel_max_mm() const { return enamel_max_mm_; }

 private:
  double Height(const dvec3& p) const { return Dot(p, rise_); }
  double Depth(const std::vector<float>& grid, const dvec3& p) const;
  void SampleDepths(const mesh::Solid& solid, const dvec3* gum);
  void Smooth(std::vector<float>& grid) const;
  double EnamelThickness(double height) const;

  dvec3 lo_, step_{0};
  ivec3 size_{0};
  std::vector<float> depth_, smooth_depth_, gum_depth_;  // (nz, ny, nx), x fastest, mm
  dvec3 rise_;                                           // away from the gum
  double bottom_ = 0, top_ = 0;                          // heights of the crown
  double enamel_max_mm_ = 0;
  double pulp_depth_ = 0, pulp_top_ = 0;
};

}  // namespace enamel::import
