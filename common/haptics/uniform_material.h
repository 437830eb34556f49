#pragma once

#include "common/haptics/coupling.h"

namespace enamel::haptics {

// The same contact everywhere and in every direction of travel; nothing is worn away. What a law is
// tried in when the geometry of a cut is not the question. Whoever owns it may change the contact
// between ticks.
class UniformMaterial final : public Material {
 public:
  UniformMaterial() = default;
  explicit UniformMaterial(const Sym3& b_n_s_per_m) {
    contact.damping_n_s_per_m = b_n_s_per_m;
    contact.engaged = true;
    contact.clearance_m = 1;  // no surface to step over: the whole tick is one step
  }
  Contact ContactAt(const dvec3&, const dvec3&) noexcept override { return contact; }
  void AnchorMoved(const dvec3&, const dvec3&) noexcept override {}

  Contact contact;
};

}  // namespace enamel::haptics
