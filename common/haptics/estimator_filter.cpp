#include <cmath>

#include "common/haptics/estimator.h"

// Estimators with a recursive state: low-pass, Kalman, Levant.
namespace enamel::haptics {
namespace {

// H(z) = f (1 - z^-1) filtered by the bilinear first-order low-pass of time constant tau.
class LowPass final : public VelocityEstimator {
 public:
  explicit LowPass(const EstimatorParams& p)
      : keep_((2 * p.time_constant_s - p.tick_s) / (2 * p.time_constant_s + p.tick_s)),
        gain_(2 / (2 * p.time_constant_s + p.tick_s)) {}
  void Reset(double p) noexcept override {
    p_ = p;
    v_ = 0;
  }
  double Update(double p) noexcept override {
    v_ = keep_ * v_ + gain_ * (p - p_);
    p_ = p;
    return v_;
  }
  void VisitState(StateArchive& archive) override { archive(p_, v_); }

 private:
  double keep_, gain_, p_ = 0, v_ = 0;
};

// State (x, v), x' = x + T v, driven by an acceleration that is constant within a tick and white
// between ticks; measurement noise variance delta^2 / 12.
class Kalman final : public VelocityEstimator {
 public:
  explicit Kalman(const EstimatorParams& p)
      : tick_(p.tick_s),
        noise_(p.resolution_m * p.resolution_m / 12),
        push_(p.acceleration_m_per_s2 * p.acceleration_m_per_s2) {}
  void Reset(double p) noexcept override {
    x_ = p;
    v_ = 0;
    pxx_ = noise_;
    pxv_ = 0;
    pvv_ = 0;
  }
  double Update(double p) noexcept override {
    double t = tick_, t2 = t * t;
    x_ += t * v_;
    pxx_ += 2 * t * pxv_ + t2 * pvv_ + push_ * t2 * t2 / 4;
    pxv_ += t * pvv_ + push_ * t2 * t / 2;
    pvv_ += push_ * t2;
    double kx = pxx_ / (pxx_ + noise_), kv = pxv_ / (pxx_ + noise_), off = p - x_;
    x_ += kx * off;
    v_ += kv * off;
    pvv_ -= kv * pxv_;
    pxv_ -= kx * pxv_;
    pxx_ -= kx * pxx_;
    return v_;
  }
  void VisitState(StateArchive& archive) override { archive(x_, v_, pxx_, pxv_, pvv_); }

 private:
  double tick_, noise_, push_, x_ = 0, v_ = 0, pxx_ = 0, pxv_ = 0, pvv_ = 0;
};

// z0' = -1.5 sqrt(L |s|) sign(s) + z1, z1' = -1.1 L sign(s), s = z0 - p; explicit Euler.
class Levant final : public VelocityEstimator {
 public:
  explicit Levant(const EstimatorParams& p)
      : tick_(p.tick_s),
        lipschitz_(p.acceleration_m_per_s2),
        root_(1.5 * std::sqrt(p.acceleration_m_per_s2)) {}
  void Reset(double p) noexcept override {
    z0_ = p;
    z1_ = 0;
  }
  double Update(double p) noexcept override {
    double s = z0_ - p, sign = s > 0 ? 1 : s < 0 ? -1 : 0;
    z0_ += tick_ * (z1_ - root_ * std::sqrt(std::fabs(s)) * sign);
    z1_ -= tick_ * 1.1 * lipschitz_ * sign;
    return z1_;
  }
  void VisitState(StateArchive& archive) override { archive(z0_, z1_); }

 private:
  double tick_, lipschitz_, root_, z0_ = 0, z1_ = 0;
};

}  // namespace

std::unique_ptr<VelocityEstimator> MakeLowPassEstimator(const EstimatorParams& params) {
  return std::make_unique<LowPass>(params);
}
std::unique_ptr<VelocityEstimator> MakeKalmanEstimator(const EstimatorParams& params) {
  return std::make_unique<Kalman>(params);
}
std::unique_ptr<VelocityEstimator> MakeLevantEstimator(const EstimatorParams& params) {
  return std::make_unique<Levant>(params);
}

}  // namespace enamel::haptics
