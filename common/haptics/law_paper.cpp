#include "common/haptics/force_law.h"

namespace enamel::haptics {
namespace {

// Liu et al. 2008. Kept as printed, including what makes it unusable at cutting speed on real
// encoders, so that its tables can be reproduced beside ours.
class Paper final : public ForceLaw {
 public:
  Paper(const LawParams& params, bool limited)
      : params_(params),
        limited_(limited),
        printed_(params.estimator.kind == EstimatorKind::kLawsOwn),
        estimators_(params.estimator, EstimatorKind::kBackwardDifference, params.resolution_m,
                    params.tick_s) {
    Reset(dvec3(0));
  }

  bool anchored() const noexcept override { return false; }
  void Reset(const dvec3& tip_m) noexcept override {
    tip_ = previous_ = tip_m;
    sent_ = velocity_ = dvec3(0);
    estimators_.Reset(tip_m);
  }
  void BeginTick(const dvec3& tip_m) noexcept override {
    previous_ = tip_;
    tip_ = tip_m;
    velocity_ = printed_ ? (tip_ - previous_) / params_.tick_s : estimators_.Update(tip_m);
  }
  dvec3 TipForce(const Sym3& b) noexcept override {
    dvec3 wanted = b * velocity_;  // eq. 1
    sent_ = limited_ ? Limit(wanted, tip_ - previous_) : wanted;
    return sent_;
  }
  void VisitState(StateArchive& archive) override {
    archive(tip_, previous_, sent_, velocity_);
    estimators_.VisitState(archive);
  }

 private:
  // eq. 17: s = (R_c - R_{i-1}).dp / dp.dp; below Kc send R_c, otherwise R_{i-1} + Kc dp.
  dvec3 Limit(const dvec3& wanted, const dvec3& dp) const noexcept {
    double dp2 = Dot(dp, dp);
    if (dp2 == 0) return params_.pass_through_at_rest ? wanted : sent_;
    double slope = Dot(wanted - sent_, dp) / dp2;
    return slope < params_.kc_n_per_m ? wanted : sent_ + params_.kc_n_per_m * dp;
  }

  LawParams params_;
  bool limited_, printed_;
  AxisVelocities estimators_;
  dvec3 tip_{0}, previous_{0}, sent_{0}, velocity_{0};
};

}  // namespace

std::unique_ptr<ForceLaw> MakePaperDamping(const LawParams& params) {
  return std::make_unique<Paper>(params, false);
}
std::unique_ptr<ForceLaw> MakePaperLimited(const LawParams& params) {
  return std::make_unique<Paper>(params, true);
}

}  // namespace enamel::haptics
