#include "common/haptics/force_law.h"

namespace enamel::haptics {
namespace {

// Maxwell coupling: a spring Kc in series with the damper B. In one dimension the stretch obeys
// de/dt = v_tip - Kc e / B, taken implicitly: e' = e / (1 + Kc dt / B). In three dimensions
// e' = (I + Kc dt B^-1)^-1 e = B (B + Kc dt I)^-1 e, which is defined for every B >= 0: B = 0 gives
// e' = 0 (air: the anchor is at the tip), B -> infinity gives e' = e (a wall of stiffness Kc).
// Then R = Kc e' = B (e - e') / dt = B V_anchor exactly: eq. 1 for the bur that cuts.
// P = B (B + Kc dt I)^-1 is symmetric with eigenvalues b/(b + Kc dt) in [0, 1).
class Maxwell final : public ForceLaw {
 public:
  explicit Maxwell(const LawParams& params) : params_(params) {}

  bool anchored() const noexcept override { return true; }
  void Reset(const dvec3&) noexcept override {}
  void BeginTick(const dvec3&) noexcept override {}
  dvec3 Relax(const dvec3& e_m, const Sym3& b, double dt_s) noexcept override {
    double s = params_.kc_n_per_m * dt_s;
    if (!(s > 0)) return e_m;
    return b * SolveShifted(b, s, e_m);
  }
  void VisitState(StateArchive&) override {}

 private:
  LawParams params_;
};

}  // namespace

std::unique_ptr<ForceLaw> MakeMaxwell(const LawParams& params) {
  return std::make_unique<Maxwell>(params);
}

}  // namespace enamel::haptics
