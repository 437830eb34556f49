#pragma once

#include "common/haptics/coupling.h"

namespace enamel::station::qualify {

// The same damping everywhere and in every direction of travel; nothing is worn away.
class UniformMaterial final : public haptics::Material {
 public:
  explicit UniformMaterial(const Sym3& b_n_s_per_m) {
    contact_.damping_n_s_per_m = b_n_s_per_m;
    contact_.engaged = true;
    contact_.clearance_m = 1;  // no surface to step over: the whole tick is one step
  }
  haptics::Contact ContactAt(const dvec3&, const dvec3&) noexcept override { return contact_; }
  void AnchorMoved(const dvec3&, const dvec3&) noexcept override {}

 private:
  haptics::Contact contact_;
};

}  // namespace enamel::station::qualify
