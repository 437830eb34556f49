#include "common/haptics/force_law.h"

namespace enamel::haptics {
namespace {

// Maxwell coupling: a spring Kc from the tip to the bur, which moves through tissue as R/B. In one
// dimension the stretch obeys de/dt = v_tip - Kc e/B. So R = B V_bur at every instant (eq. 1 for the
// bur that cuts), it is defined without a count, in air (B = 0) and at a wall (B infinite), and in a
// hand that prescribes its speed it comes up as 1 - exp(-t Kc/B).
class Maxwell final : public ForceLaw {
 public:
  explicit Maxwell(const LawParams& params) : kc_(params.kc_n_per_m) {}

  bool anchored() const noexcept override { return true; }
  void Reset(const dvec3& tip_m) noexcept override { tip_ = tip_m; }
  void BeginTick(const dvec3& tip_m) noexcept override { tip_ = tip_m; }
  Pull PullOn(const dvec3& anchor_m, const Sym3&) noexcept override {
    return {tip_ - anchor_m, kc_};
  }
  void VisitState(StateArchive& archive) override { archive(tip_); }

 private:
  double kc_;
  dvec3 tip_{0};
};

}  // namespace

std::unique_ptr<ForceLaw> MakeMaxwell(const LawParams& params) {
  return std::make_unique<Maxwell>(params);
}

}  // namespace enamel::haptics
