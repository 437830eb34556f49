#include "common/haptics/estimator.h"

#include <array>

#include "common/base/check.h"

namespace enamel::haptics {
namespace {

constexpr std::array kEstimators = {
    EstimatorEntry{EstimatorKind::kBackwardDifference, "difference", "difference of one tick",
                   &MakeBackwardDifference},
    EstimatorEntry{EstimatorKind::kWindow, "window", "difference over a fixed window",
                   &MakeWindowEstimator},
    EstimatorEntry{EstimatorKind::kLowPass, "lowpass", "first-order low-pass of the difference",
                   &MakeLowPassEstimator},
    EstimatorEntry{EstimatorKind::kFoawEndFit, "foaw-end",
                   "adaptive window, slope through its ends", &MakeFoawEndFit},
    EstimatorEntry{EstimatorKind::kFoawBestFit, "foaw-best", "adaptive window, least-squares slope",
                   &MakeFoawBestFit},
    EstimatorEntry{EstimatorKind::kKalman, "kalman", "constant-velocity Kalman filter",
                   &MakeKalmanEstimator},
    EstimatorEntry{EstimatorKind::kLevant, "levant", "super-twisting differentiator",
                   &MakeLevantEstimator},
};

}  // namespace

std::span<const EstimatorEntry> VelocityEstimators() { return kEstimators; }

const EstimatorEntry* FindEstimator(std::string_view name) {
  for (const auto& e : kEstimators) {
    if (e.name == name) return &e;
  }
  return nullptr;
}

const EstimatorEntry* FindEstimator(EstimatorKind kind) {
  for (const auto& e : kEstimators) {
    if (e.kind == kind) return &e;
  }
  return nullptr;
}

AxisVelocities::AxisVelocities(EstimatorParams params, EstimatorKind kind,
                               const dvec3& resolution_m, double tick_s) {
  if (params.kind != EstimatorKind::kLawsOwn) kind = params.kind;
  const EstimatorEntry* entry = FindEstimator(kind);
  ENAMEL_CHECK(entry != nullptr);
  params.tick_s = tick_s;
  for (int i = 0; i < 3; ++i) {
    params.resolution_m = resolution_m[i];
    axes_[i] = entry->make(params);
  }
}

void AxisVelocities::Reset(const dvec3& p) noexcept {
  for (int i = 0; i < 3; ++i) axes_[i]->Reset(p[i]);
}

dvec3 AxisVelocities::Update(const dvec3& p) noexcept {
  return {axes_[0]->Update(p.x), axes_[1]->Update(p.y), axes_[2]->Update(p.z)};
}

void AxisVelocities::VisitState(StateArchive& archive) {
  for (auto& axis : axes_) axis->VisitState(archive);
}

}  // namespace enamel::haptics
