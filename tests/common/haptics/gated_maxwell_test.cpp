#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "common/haptics/coupling.h"

namespace enamel::haptics {
namespace {

class Uniform final : public Material {
 public:
  explicit Uniform(double b) : b_(Sym3::Isotropic(b)) {}
  Contact ContactAt(const dvec3&, const dvec3&) noexcept override {
    Contact c;
    c.damping_n_s_per_m = b_;
    c.engaged = true;
    return c;
  }
  void AnchorMoved(const dvec3&, const dvec3&) noexcept override {}

 private:
  Sym3 b_;
};

struct Device {
  const char* name;
  double delta_m, kc_n_per_m;
};
const Device kDevices[] = {
    {"omega3", 9e-6, 10e3}, {"phantom_desktop", 10e-6, 2.5e3}, {"bhhd3", 20e-6, 4e3}};
constexpr double kB = 6500, kSpeed = 0.43e-3;

dvec3 Cell(const dvec3& x, double delta) {
  return (dvec3(std::floor(x.x / delta), std::floor(x.y / delta), std::floor(x.z / delta)) + 0.5) *
         delta;
}

struct Response {
  double error_per_axis_n = 0, rise_s = -1, release_s = -1, ripple_n = 0;
};

// A hand that prescribes velocity: starts, cuts until settled, stops.
Response VelocityHand(const Device& device, LawKind law, const dvec3& direction) {
  CouplingParams p;
  p.law = {law, device.kc_n_per_m, dvec3(device.delta_m), 1e-3, false};
  p.peak_force_n = 50;
  Coupling coupling(p);
  Uniform enamel(kB);
  double tau = kB / device.kc_n_per_m, target = kB * kSpeed;
  auto tip = [&](int tick) {
    return Cell(direction * (kSpeed * 1e-3 * tick) + dvec3(3.3e-6, 2.1e-6, 1e-6), device.delta_m);
  };
  coupling.Reset(tip(0));
  Response r;
  int n = static_cast<int>((6 * tau + 3) * 1000);
  std::vector<double> settled;
  for (int i = 0; i < n; ++i) {
    dvec3 f = -coupling.Tick(tip(i), 1, enamel).force_sent_n;
    double along = glm::dot(f, direction);
    if (r.rise_s < 0 && along >= 0.9 * target) r.rise_s = i * 1e-3;
    if (i < n - 2000) continue;
    settled.push_back(along);
    for (int a = 0; a < 3; ++a) {
      r.error_per_axis_n = std::max(r.error_per_axis_n, std::fabs(f[a] - target * direction[a]));
    }
  }
  double mean = 0, square = 0;
  for (double f : settled) mean += f / settled.size();
  for (double f : settled) square += (f - mean) * (f - mean) / settled.size();
  r.ripple_n = std::sqrt(square);
  for (int i = 0; i < 3000 && r.release_s < 0; ++i) {
    if (glm::length(coupling.Tick(tip(n - 1), 1, enamel).force_sent_n) <= 0.1 * target)
      r.release_s = i * 1e-3;
  }
  return r;
}

// 2.8 N on all three devices of the paper, in any direction. Bounds: the encoder's own Kc delta / 2
// per axis (times 1.15), ripple of one count through the spring, rise against the slope limit's own
// time 0.9 B v / (Kc v) (and the tick it is noticed in), release against the plain coupling's 2.3 B/Kc.
TEST(GatedMaxwellTest, EveryDeviceCarriesTheFullCuttingForce) {
  for (const Device& device : kDevices) {
    for (dvec3 d : {dvec3(1, 0, 0), glm::normalize(dvec3(1, 1, 0)), glm::normalize(dvec3(1, 2, 3)),
                    glm::normalize(dvec3(1, 0.1, 0.05)), glm::normalize(dvec3(1, -0.4, 0.02))}) {
      Response r = VelocityHand(device, LawKind::kGatedMaxwell, d);
      double tau = kB / device.kc_n_per_m;
      EXPECT_LE(r.error_per_axis_n, std::max(0.05, 1.15 * device.kc_n_per_m * device.delta_m / 2))
          << device.name;
      EXPECT_LE(r.ripple_n, 0.030) << device.name;
      EXPECT_LE(r.rise_s, 1.15 * 0.9 * tau + 1e-3) << device.name;
      EXPECT_GE(r.release_s, 0) << device.name;
      EXPECT_LE(r.release_s, 0.4 * tau) << device.name;
    }
  }
}

TEST(GatedMaxwellTest, RisesAtTheSlopeLimitWherePlainMaxwellTakesItsTimeConstant) {
  const Device& phantom = kDevices[1];
  double gated = VelocityHand(phantom, LawKind::kGatedMaxwell, dvec3(1, 0, 0)).rise_s;
  double plain = VelocityHand(phantom, LawKind::kMaxwell, dvec3(1, 0, 0)).rise_s;
  // Closed form of the plain coupling: ln(10) B/Kc.
  EXPECT_NEAR(plain, std::log(10.0) * kB / phantom.kc_n_per_m, 0.1);
  EXPECT_LT(gated, 0.5 * plain);
}

// A tip that rests is let go of down to what the guard must leave, half a cell per axis, also where
// the stretch is oblique.
TEST(GatedMaxwellTest, LetsGoToHalfACellOnEveryAxis) {
  for (const Device& device : kDevices) {
    CouplingParams p;
    p.law = {LawKind::kGatedMaxwell, device.kc_n_per_m, dvec3(device.delta_m), 1e-3, false};
    p.peak_force_n = 50;
    Coupling coupling(p);
    Uniform enamel(kB);
    coupling.Reset(dvec3(0));
    dvec3 tip = Cell(dvec3(1, 2, 3) * 20e-6, device.delta_m), force(0);
    for (int i = 0; i < 20000; ++i) force = coupling.Tick(tip, 1, enamel).force_sent_n;
    for (int a = 0; a < 3; ++a)
      EXPECT_LE(std::fabs(force[a]), device.kc_n_per_m * device.delta_m / 2 * (1 + 1e-9));
  }
}

// The law's contract: e' = P e with 0 <= P <= I means the stretch never grows and never points away.
TEST(GatedMaxwellTest, StretchOnlyEverShrinks) {
  auto law = MakeGatedMaxwell({LawKind::kGatedMaxwell, 2500, dvec3(10e-6), 1e-3, false});
  law->Reset(dvec3(0));
  uint64_t state = 1;
  auto random = [&] {
    state = state * 6364136223846793005ull + 1442695040888963407ull;
    return static_cast<double>(state >> 33) / 4294967296.0 - 0.5;
  };
  dvec3 tip(0), e(0);
  for (int i = 0; i < 20000; ++i) {
    dvec3 step =
        dvec3(std::round(random() * 2.2), std::round(random() * 2.2), std::round(random() * 2.2)) *
        10e-6;
    tip += step;
    law->BeginTick(tip);
    e += step;
    Sym3 b;
    for (int k = 0; k < 1 + i % 3; ++k)
      b += Sym3::Outer(dvec3(random(), random(), random()), 20000);
    dvec3 next = law->Relax(e, b, 1e-3);
    ASSERT_LE(glm::dot(next, next), glm::dot(e, e) * (1 + 1e-9) + 1e-30);
    ASSERT_GE(glm::dot(next, e), -1e-9 * glm::dot(e, e));
    e = next;
  }
}

}  // namespace
}  // namespace enamel::haptics
