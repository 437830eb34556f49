#pragma once

#include <algorithm>

#include "common/haptics/force_law.h"

// Tissue beyond a plane that is across no axis. What the bur has passed is gone. SI units.
namespace enamel::station::lab {

class HalfSpace final : public haptics::Material {
 public:
  static inline const dvec3 kInward = glm::normalize(dvec3(1, 2, 3));

  // `surface_m`: the plane's distance from 0 along kInward.
  HalfSpace(double b_n_s_per_m, double surface_m) : b_(b_n_s_per_m), surface_m_(surface_m) {}

  haptics::Contact ContactAt(const dvec3& anchor, const dvec3& stretch) noexcept override {
    haptics::Contact c;
    const double left = surface_m_ - Dot(anchor, kInward);
    if (left > 1e-12) {
      c.clearance_m = left;
      return c;
    }
    c.clearance_m = 1;
    if (!(Dot(stretch, kInward) > 0)) return c;
    c.engaged = true;
    if (wall) {
      c.wall_normal = kInward;
    } else {
      c.damping_n_s_per_m = Sym3::Isotropic(b_);
    }
    return c;
  }
  void AnchorMoved(const dvec3&, const dvec3& to) noexcept override {
    surface_m_ = std::max(surface_m_, Dot(to, kInward));
  }
  double surface_m() const { return surface_m_; }
  // The tissue up to there is gone.
  void Retreat(double to_m) { surface_m_ = std::max(surface_m_, to_m); }
  bool wall = false;

 private:
  double b_, surface_m_;
};

}  // namespace enamel::station::lab
