#pragma once

#include "common/haptics/coupling.h"

namespace enamel::station::qualify {

// The same contact everywhere and in every direction of travel; nothing is worn away. A game may change it
// between ticks.
class UniformMaterial final : public haptics::Material {
 public:
  UniformMaterial() = default;
  explicit UniformMaterial(const Sym3& b_n_s_per_m) {
    contact.damping_n_s_per_m = b_n_s_per_m;
    contact.engaged = true;
    contact.clearance_m = 1;  // no surface to step over: the whole tick is one step
  }
  haptics::Contact ContactAt(const dvec3&, const dvec3&) noexcept override { return contact; }
  void AnchorMoved(const dvec3&, const dvec3&) noexcept override {}

  haptics::Contact contact;
};

}  // namespace enamel::station::qualify
