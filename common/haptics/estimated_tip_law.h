#pragma once

#include "common/haptics/estimator.h"
#include "common/haptics/force_law.h"

namespace enamel::haptics {

// What the tip laws that work on an estimated velocity share: the step of this tick, the estimate and
// the resisting force sent last. Thread safety, real-time: as ForceLaw.
class EstimatedTipLaw : public ForceLaw {
 public:
  // `fallback`: the estimator where LawParams names none.
  EstimatedTipLaw(const LawParams& params, EstimatorKind fallback)
      : params_(params),
        estimators_(params.estimator, fallback, params.resolution_m, params.tick_s) {}

  bool anchored() const noexcept override { return false; }
  void Reset(const dvec3& tip_m) noexcept override {
    tip_ = tip_m;
    step_ = sent_ = velocity_ = dvec3(0);
    estimators_.Reset(tip_m);
  }
  void BeginTick(const dvec3& tip_m) noexcept override {
    step_ = tip_m - tip_;
    tip_ = tip_m;
    velocity_ = estimators_.Update(tip_m);
  }
  void VisitState(StateArchive& archive) override {
    archive(tip_, step_, sent_, velocity_);
    estimators_.VisitState(archive);
  }

 protected:
  LawParams params_;
  AxisVelocities estimators_;
  dvec3 tip_{0}, step_{0}, sent_{0}, velocity_{0};
};

}  // namespace enamel::haptics
