#include "common/haptics/estimated_tip_law.h"

namespace enamel::haptics {
namespace {

// Time-domain passivity control of Hannaford and Ryu (IEEE TRA 18(1) 2002) around eq. 1. Observer:
// W_k = W_{k-1} + R_{k-1} . dp_k, exact for a held force but for quantisation. Controller: where W
// < 0 a damper alpha = -W T / (dp . dp) is added, at most Kc T, which takes the deficit back over
// the next step if that step is as long as the last. Where dp = 0 it can do nothing. Eq. 2 of Liu
// et al. is this observer.
class PassivityControlled final : public EstimatedTipLaw {
 public:
  explicit PassivityControlled(const LawParams& params)
      : EstimatedTipLaw(params, EstimatorKind::kBackwardDifference) {
    Reset(dvec3(0));
  }

  void Reset(const dvec3& tip_m) noexcept override {
    EstimatedTipLaw::Reset(tip_m);
    energy_j_ = 0;
  }
  void BeginTick(const dvec3& tip_m) noexcept override {
    EstimatedTipLaw::BeginTick(tip_m);
    energy_j_ += Dot(sent_, step_);
  }
  dvec3 TipForce(const Sym3& b) noexcept override {
    sent_ = b * velocity_;
    double moved2 = Dot(step_, step_);
    if (energy_j_ < 0 && moved2 > 0) {
      double most = params_.kc_n_per_m, stiffness = -energy_j_ / moved2;
      sent_ += step_ * (stiffness < most ? stiffness : most);
    }
    return sent_;
  }
  void VisitState(StateArchive& archive) override {
    EstimatedTipLaw::VisitState(archive);
    archive(energy_j_);
  }

 private:
  double energy_j_ = 0;
};

}  // namespace

std::unique_ptr<ForceLaw> MakePassivityControlled(const LawParams& params) {
  return std::make_unique<PassivityControlled>(params);
}

}  // namespace enamel::haptics
