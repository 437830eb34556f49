#include "common/haptics/estimated_tip_law.h"

namespace enamel::haptics {
namespace {

// Energy bounding of Kim and Ryu (IJRR 29(6) 2010) around eq. 1, per axis:
// R_k = R_{k-1} + beta dp_k with beta bounded so that the device's own damping pays. With storage
// R^2 / (2 c1), c1 = Kc <= 2 b / T, step k needs
//   R_{k-1} dp + (b / T) dp^2 >= (R_k^2 - R_{k-1}^2) / (2 c1)
// which factors into (c1 - beta) (2 R_{k-1} / dp + c1 + beta) >= 0. So beta lies between c1 and
// -c1 - 2 R_{k-1} / dp. Proved for unquantised positions only. Holds where dp = 0.
class EnergyBounded final : public EstimatedTipLaw {
 public:
  explicit EnergyBounded(const LawParams& params)
      : EstimatedTipLaw(params, EstimatorKind::kBackwardDifference) {
    Reset(dvec3(0));
  }

  dvec3 TipForce(const Sym3& b) noexcept override {
    dvec3 wanted = b * velocity_;
    for (int i = 0; i < 3; ++i) {
      if (step_[i] == 0) continue;
      double one = params_.kc_n_per_m, other = -one - 2 * sent_[i] / step_[i];
      double low = one < other ? one : other, high = one < other ? other : one;
      double beta = (wanted[i] - sent_[i]) / step_[i];
      sent_[i] += step_[i] * (beta < low ? low : beta > high ? high : beta);
    }
    return sent_;
  }
};

}  // namespace

std::unique_ptr<ForceLaw> MakeEnergyBounded(const LawParams& params) {
  return std::make_unique<EnergyBounded>(params);
}

}  // namespace enamel::haptics
