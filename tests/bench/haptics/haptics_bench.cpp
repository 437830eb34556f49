// Nanoseconds per tick of every force law (with its estimator and the output chain) and of every
// velocity estimator, on a quantised oblique cut.
#include <benchmark/benchmark.h>

#include <cmath>
#include <string>
#include <vector>

#include "common/haptics/coupling.h"
#include "common/haptics/estimator.h"

namespace {

using namespace enamel;
using namespace enamel::haptics;

constexpr double kDelta = 10e-6, kTick = 1e-3;

class Enamel final : public Material {
 public:
  Enamel() {
    contact_.damping_n_s_per_m = Sym3::Isotropic(6500);
    contact_.engaged = true;
    contact_.clearance_m = 1;
  }
  Contact ContactAt(const dvec3&, const dvec3&) noexcept override { return contact_; }
  void AnchorMoved(const dvec3&, const dvec3&) noexcept override {}

 private:
  Contact contact_;
};

double Cell(double x) { return (std::floor(x / kDelta) + 0.5) * kDelta; }

// A cut at `speed` (m/s) along (1, 2, 3), long enough for windows to fill.
std::vector<dvec3> Way(double speed) {
  std::vector<dvec3> tips(8192);
  dvec3 along = glm::normalize(dvec3(1, 2, 3)) * (speed * kTick);
  for (size_t i = 0; i < tips.size(); ++i) {
    dvec3 x = along * static_cast<double>(i);
    tips[i] = dvec3(Cell(x.x), Cell(x.y), Cell(x.z));
  }
  return tips;
}

void LawTick(benchmark::State& state, const LawEntry& law, double speed) {
  CouplingParams p;
  p.law.kind = law.kind;
  p.law.kc_n_per_m = 2500;
  p.law.resolution_m = dvec3(kDelta);
  p.peak_force_n = 7.9;
  Coupling coupling(p);
  Enamel enamel;
  std::vector<dvec3> tips = Way(speed);
  coupling.Reset(tips[0]);
  size_t i = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(coupling.Tick(tips[i], 1, enamel));
    if (++i == tips.size()) {
      i = 0;
      coupling.Reset(tips[0]);
    }
  }
}

void EstimatorUpdate(benchmark::State& state, const EstimatorEntry& entry, double speed) {
  EstimatorParams p;
  p.kind = entry.kind;
  p.resolution_m = kDelta;
  p.window_ticks = 256;
  auto estimator = entry.make(p);
  std::vector<dvec3> tips = Way(speed);
  estimator->Reset(tips[0].z);
  size_t i = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(estimator->Update(tips[i].z));
    i = i + 1 < tips.size() ? i + 1 : 0;
  }
}

[[maybe_unused]] const bool kRegistered = [] {
  for (double speed : {0.43e-3, 10e-3}) {
    std::string at = speed < 1e-3 ? "/cutting" : "/fast";
    for (const LawEntry& law : ForceLaws()) {
      benchmark::RegisterBenchmark(("law/" + std::string(law.name) + at).c_str(),
                                   [&law, speed](benchmark::State& s) { LawTick(s, law, speed); });
    }
    for (const EstimatorEntry& entry : VelocityEstimators()) {
      benchmark::RegisterBenchmark(
          ("estimator/" + std::string(entry.name) + at).c_str(),
          [&entry, speed](benchmark::State& s) { EstimatorUpdate(s, entry, speed); });
    }
  }
  return true;
}();

}  // namespace
