#include "tests/station/lab/tissue/recorded_cut.h"

#include <algorithm>
#include <cmath>

#include "common/fidelity/plant.h"

namespace enamel::station::lab {

using fidelity::Random;
namespace {

constexpr int kSubsteps = 2;  // of a sample, midpoint rule

// Speed of the front under `f`: fixed point of (B + Fc/|V|) V = F, starting from the last speed.
dvec3 Answer(const TrueCut& truth, const dvec3& f, const dvec3& before = dvec3(0)) {
  double size = glm::length(f);
  if (size < truth.threshold_n || size <= truth.coulomb_n) return dvec3(0);
  if (truth.root > 0) {
    const double speed = (size - truth.coulomb_n) / truth.root;
    return f * (speed * speed / size);
  }
  if (truth.coulomb_n == 0) return glm::inverse(truth.b) * f;
  dvec3 v = glm::length(before) > 1e-3
                ? before
                : glm::inverse(truth.b) * (f * ((size - truth.coulomb_n) / size));
  for (int i = 0; i < 60; ++i) {
    dvec3 next = glm::inverse(truth.b + dmat3(truth.coulomb_n / glm::length(v))) * f;
    bool close = glm::length(next - v) < 1e-9 * glm::length(v);
    v = next;
    if (close) break;
  }
  return v;
}

void Record(const Sensor& sensor, Random* random, double t, dvec3 x, dvec3 f,
            std::vector<CutSample>* out) {
  for (int k = 0; k < 3; ++k) {
    x[k] += sensor.position_noise_mm * random->Normal();
    if (sensor.count_mm > 0) x[k] = sensor.count_mm * (std::floor(x[k] / sensor.count_mm) + 0.5);
    f[k] += sensor.force_noise_n * random->Normal();
  }
  if (random->Uniform() < sensor.dropped) return;
  if (random->Uniform() < sensor.spikes) {
    f += 20.0 * random->Direction();
    x += 1.0 * random->Direction();
  }
  out->push_back({t, x, f, dvec3(0), 0});
}

}  // namespace

std::vector<CutSample> CutByForce(const TrueCut& truth, const Sensor& sensor, double seconds,
                                  uint64_t seed, const std::function<dvec3(double)>& force_n) {
  Random random(seed);
  std::vector<CutSample> out;
  dvec3 x(random.Uniform(), random.Uniform(), random.Uniform()), v(0);
  double dt = 1 / sensor.rate_hz / kSubsteps;
  auto rows = static_cast<long>(seconds * sensor.rate_hz);
  for (long i = 0; i < rows; ++i) {
    double t = static_cast<double>(i) / sensor.rate_hz;
    dvec3 f = force_n(t);
    const dvec3 read = f + glm::cross(dvec3(0, 0, 1), f) * truth.friction;
    Record(sensor, &random, t, x + truth.compliance_mm_per_n * f, read, &out);
    for (int k = 0; k < kSubsteps; ++k) {
      v = Answer(truth, force_n(t + (k + 0.5) * dt), v);
      x += dt * v;
    }
  }
  return out;
}

std::vector<CutSample> CutByMotion(const TrueCut& truth, const Sensor& sensor, double seconds,
                                   uint64_t seed, const std::function<dvec3(double)>& position_mm) {
  Random random(seed);
  std::vector<CutSample> out;
  dvec3 shift(random.Uniform(), random.Uniform(), random.Uniform()), front = position_mm(0);
  double dt = 1 / sensor.rate_hz / kSubsteps;
  auto rows = static_cast<long>(seconds * sensor.rate_hz);
  for (long i = 0; i < rows; ++i) {
    double t = static_cast<double>(i) / sensor.rate_hz;
    dvec3 p = position_mm(t);
    Record(sensor, &random, t, p + shift, (p - front) / truth.compliance_mm_per_n, &out);
    for (int k = 0; k < kSubsteps; ++k) {
      double at = t + k * dt, c = truth.compliance_mm_per_n;
      dvec3 half = front + 0.5 * dt * Answer(truth, (position_mm(at) - front) / c);
      front += dt * Answer(truth, (position_mm(at + 0.5 * dt) - half) / c);
    }
  }
  return out;
}

}  // namespace enamel::station::lab
