#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string_view>

#include "common/base/state_archive.h"
#include "common/math/vec.h"

// Velocity from quantised positions, one axis at a time. Notation: p_k cell middle at tick k, T
// tick, f = 1/T, delta cell edge; |p_k - x_k| <= delta/2, so a difference over n ticks is wrong by
// at most delta f / n (Liu et al. 2008 write 2 delta f, with |p - x| <= delta).
namespace enamel::haptics {

// Stable numbers.
enum class EstimatorKind : uint8_t {
  kLawsOwn = 0,             // what the law's own header says
  kBackwardDifference = 1,  // (p_k - p_{k-1}) f
  kWindow = 2,              // (p_k - p_{k-n}) f / n, n fixed
  kLowPass = 3,      // first-order low-pass of the backward difference, bilinear in the difference
  kFoawEndFit = 4,   // first-order adaptive window, slope through the end points
  kFoawBestFit = 5,  // the same with the least-squares slope
  kKalman = 6,       // constant velocity driven by white acceleration, noise delta^2 / 12
  kLevant = 7,       // robust exact differentiator (super-twisting)
};

struct EstimatorParams {
  EstimatorKind kind = EstimatorKind::kLawsOwn;
  double tick_s = 0.001;
  double resolution_m = 10e-6;
  int window_ticks = 128;         // kWindow: 1..1024; FOAW: largest window, 2..256
  double time_constant_s = 0.02;  // kLowPass
  double acceleration_m_per_s2 =
      0.05;  // kKalman: standard deviation per tick; kLevant: largest |x''|
};

// Thread safety: none. Real-time: Update and Reset are safe; memory is fixed at construction.
class VelocityEstimator {
 public:
  virtual ~VelocityEstimator() = default;
  // At rest at p, no history.
  virtual void Reset(double p_m) noexcept = 0;
  // Once per tick. Returns m/s.
  virtual double Update(double p_m) noexcept = 0;
  // Saves or restores all that Update depends on.
  virtual void VisitState(StateArchive& archive) = 0;
};

// A new estimator is one class, one factory and one line in the registry (estimator.cpp).
//
// Sources: FOAW, Janabi-Sharifi, Hayward, Chen, IEEE TCST 8(6) 2000: the longest window whose
// samples all lie within delta of the line through its ends. Kalman gains converge to Kalata, IEEE
// TAES 20(2) 1984. Levant, Automatica 34(3) 1998, gains 1.5 sqrt(L) and 1.1 L.
struct EstimatorEntry {
  EstimatorKind kind;
  std::string_view name;
  std::string_view summary;
  std::unique_ptr<VelocityEstimator> (*make)(const EstimatorParams&);
};
std::span<const EstimatorEntry> VelocityEstimators();
// nullptr when unknown.
const EstimatorEntry* FindEstimator(std::string_view name);
const EstimatorEntry* FindEstimator(EstimatorKind kind);

std::unique_ptr<VelocityEstimator> MakeBackwardDifference(const EstimatorParams& params);
std::unique_ptr<VelocityEstimator> MakeWindowEstimator(const EstimatorParams& params);
std::unique_ptr<VelocityEstimator> MakeLowPassEstimator(const EstimatorParams& params);
std::unique_ptr<VelocityEstimator> MakeFoawEndFit(const EstimatorParams& params);
std::unique_ptr<VelocityEstimator> MakeFoawBestFit(const EstimatorParams& params);
std::unique_ptr<VelocityEstimator> MakeKalmanEstimator(const EstimatorParams& params);
std::unique_ptr<VelocityEstimator> MakeLevantEstimator(const EstimatorParams& params);

// One estimator per axis, as the laws use them. `kind` is what to build when params leave it to the
// law; resolution is set per axis.
class AxisVelocities {
 public:
  AxisVelocities(EstimatorParams params, EstimatorKind kind, const dvec3& resolution_m,
                 double tick_s);
  void Reset(const dvec3& p_m) noexcept;
  dvec3 Update(const dvec3& p_m) noexcept;
  void VisitState(StateArchive& archive);

 private:
  std::unique_ptr<VelocityEstimator> axes_[3];
};

}  // namespace enamel::haptics
