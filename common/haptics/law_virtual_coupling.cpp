#include "common/haptics/force_law.h"

namespace enamel::haptics {
namespace {

// Virtual coupling of Adams and Hannaford (IEEE TRA 15(3) 1999): spring Kc and damper bc from the
// device to a tool of their own, here massless in tissue B. With e = p - a before the tool moves by
// w and F = Kc (e - w) + bc (dp - w) / T = B w / T, implicit in w: F = B (B + (Kc T + bc) I)^-1 (Kc
// e + bc dp / T). bc = 0 is the plain Maxwell coupling. The damper sees the quantised difference of
// one tick, bc delta / T per count, and eats into the passive stiffness: b > Kc T / 2 + bc. A tip
// law: the bur is drawn at the tip, the tool is inside the law.
class VirtualCoupling final : public ForceLaw {
 public:
  explicit VirtualCoupling(const LawParams& params)
      : params_(params), damper_(kDamperShare * params.kc_n_per_m * params.tick_s) {}

  bool anchored() const noexcept override { return false; }
  void Reset(const dvec3& tip_m) noexcept override {
    tip_ = tool_ = tip_m;
    step_ = dvec3(0);
  }
  void BeginTick(const dvec3& tip_m) noexcept override {
    step_ = tip_m - tip_;
    tip_ = tip_m;
  }
  dvec3 TipForce(const Sym3& b) noexcept override {
    double kc = params_.kc_n_per_m, t = params_.tick_s, whole = kc * t + damper_;
    dvec3 e = tip_ - tool_;
    dvec3 pull = e * kc + step_ * (damper_ / t);
    if (!(whole > 0)) return dvec3(0);
    dvec3 force = b * SolveShifted(b, whole, pull);
    // F = pull - whole w / T.
    tool_ += (pull - force) * (t / whole);
    return force;
  }
  void VisitState(StateArchive& archive) override { archive(tip_, tool_, step_); }

 private:
  static constexpr double kDamperShare = 0.1;  // bc = 0.1 Kc T: a tenth of the stiffness it costs

  LawParams params_;
  double damper_;
  dvec3 tip_{0}, tool_{0}, step_{0};
};

}  // namespace

std::unique_ptr<ForceLaw> MakeVirtualCoupling(const LawParams& params) {
  return std::make_unique<VirtualCoupling>(params);
}

}  // namespace enamel::haptics
