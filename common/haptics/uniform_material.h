#pragma once

#include <cmath>

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
  // Tissue that is cut by load, alike in every direction.
  explicit UniformMaterial(const FeedForce& by_load) : UniformMaterial(Sym3::Isotropic(1)) {
    contact.by_load = true;
    load = by_load;
  }
  Contact ContactAt(const dvec3&, const dvec3&) noexcept override { return contact; }
  Sym3 SecantAt(const dvec3& feed_m_per_s) noexcept override {
    const double speed = std::sqrt(Dot(feed_m_per_s, feed_m_per_s));
    const double feed = speed > kCreep_m_per_s ? speed : kCreep_m_per_s;
    return Sym3::Isotropic(load.At(feed) / feed);
  }
  FeedForce ForceAlong(const dvec3&) noexcept override { return load; }
  dvec3 DragAt(const dvec3&) noexcept override { return drag_n; }
  void AnchorMoved(const dvec3&, const dvec3&) noexcept override {}

  Contact contact;
  // Where contact.by_load.
  FeedForce load;
  dvec3 drag_n{0};

 private:
  static constexpr double kCreep_m_per_s = 1e-6;  // as cutting/engagement.h has it
};

}  // namespace enamel::haptics
