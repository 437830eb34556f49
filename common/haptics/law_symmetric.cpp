#include <cmath>

#include "common/haptics/estimated_tip_law.h"

namespace enamel::haptics {
namespace {

// Eq. 12 asks that |dR/dp| <= Kc for rises and falls; eq. 17 only limits rises. Here each axis
// follows R_c = B v by at most Kc |dp_i| a tick, either way, and holds where dp_i = 0 (which
// satisfies the bound for every dp that may follow). Velocity: best-fit adaptive window unless told
// otherwise. It follows a hand that prescribes velocity; one that prescribes force sticks (v = 0
// for ever), and it never lets go of a hand that stops.
class Symmetric final : public EstimatedTipLaw {
 public:
  explicit Symmetric(const LawParams& params)
      : EstimatedTipLaw(params, EstimatorKind::kFoawBestFit) {
    Reset(dvec3(0));
  }

  dvec3 TipForce(const Sym3& b) noexcept override {
    dvec3 wanted = b * velocity_;
    for (int i = 0; i < 3; ++i) {
      double most = params_.kc_n_per_m * std::fabs(step_[i]), change = wanted[i] - sent_[i];
      sent_[i] += change > most ? most : change < -most ? -most : change;
    }
    return sent_;
  }
};

}  // namespace

std::unique_ptr<ForceLaw> MakePaperSymmetric(const LawParams& params) {
  return std::make_unique<Symmetric>(params);
}

}  // namespace enamel::haptics
