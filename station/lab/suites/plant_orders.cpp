#include <cmath>
#include <complex>

#include "common/fidelity/feel.h"
#include "station/lab/suites/orders.h"
#include "station/lab/suites/suites.h"

namespace enamel::station::lab {
namespace {

constexpr size_t kHands = 8;
constexpr double kHand_kg = 0.1, kSpeed_m_per_s = 5e-3, kDuration_s = 0.3;
constexpr double kTick_s = 1e-3;

// A mass on a spring and a damper whose other ends move at a constant speed v, with a damper b to the ground:
//   m x" + (b + d) x' + k x = k v t + d v,  x = x' = 0 at t = 0
//   x = v t - b v/k + sum of a_i exp(l_i t),  l the roots of m l^2 + (b + d) l + k
// SI units; b + d is not 2 sqrt(m k).
struct DrawnMass {
  double mass_kg, b, d, k, v;

  using Complex = std::complex<double>;
  std::array<Complex, 2> roots() const {
    const Complex root = std::sqrt(Complex((b + d) * (b + d) - 4 * mass_kg * k));
    return {(-(b + d) + root) / (2 * mass_kg), (-(b + d) - root) / (2 * mass_kg)};
  }
  std::array<Complex, 2> shares() const {
    const auto l = roots();
    const Complex first = (-v - l[1] * (b * v / k)) / (l[0] - l[1]);
    return {first, b * v / k - first};
  }
  double At_m(double t) const {
    const auto l = roots(), a = shares();
    return v * t - b * v / k + (a[0] * std::exp(l[0] * t) + a[1] * std::exp(l[1] * t)).real();
  }
  // b times the integral of x'^2, what the damper to the ground takes until t.
  double Taken_j(double t) const {
    const auto l = roots(), a = shares();
    Complex sum = v * v * t;
    for (size_t i = 0; i < 2; ++i) {
      sum += 2 * v * a[i] * (std::exp(l[i] * t) - 1.0);
      for (size_t j = 0; j < 2; ++j)
        sum += a[i] * a[j] * l[i] * l[j] * (std::exp((l[i] + l[j]) * t) - 1.0) / (l[i] + l[j]);
    }
    return b * sum.real();
  }
};

// Errors over the drawn mass: of the spring's stretch, RMS over RMS, and of the energy; in percent.
struct DrawnErrors {
  double stretch, energy;
};

DrawnErrors DrawAt(const DeviceModel& m, double grip_n_per_m, double step_s) {
  DrawnMass mass{m.mass_kg + kHand_kg, m.damping_n_s_per_m, 0, grip_n_per_m, kSpeed_m_per_s};
  mass.d = 1.2 * std::sqrt(mass.k * mass.mass_kg);  // as fidelity/felt.h has it
  fidelity::PlantSpec spec;
  spec.mass_kg = m.mass_kg;
  spec.damping_n_s_per_m = m.damping_n_s_per_m;
  spec.resolution_m = m.resolution_m;
  spec.tick_s = step_s;
  spec.substeps = 1;
  LineMotion line;
  line.speed_m_per_s = kSpeed_m_per_s;
  fidelity::ImpedanceHand hand(line, mass.k, kHand_kg, mass.d);
  Plant plant(spec, hand, dvec3(0));
  double off2 = 0, stretch2 = 0, taken = 0, t = 0;
  const auto steps = std::lround(kDuration_s / step_s);
  for (long i = 1; i <= steps; ++i) {
    plant.Step(dvec3(0));
    t = static_cast<double>(i) * step_s;
    const double right = mass.At_m(t), off = plant.tip_m().x - right,
                 stretch = kSpeed_m_per_s * t - right;
    off2 += off * off;
    stretch2 += stretch * stretch;
    taken += mass.b * plant.speed_m_per_s().x * plant.speed_m_per_s().x * step_s;
  }
  return {100 * std::sqrt(off2 / stretch2), 100 * (taken / mass.Taken_j(t) - 1)};
}

OrderRow Named(const DeviceModel& m, const char* what, const char* quantity) {
  OrderRow row;
  row.method = "plants";
  row.what = m.title + std::string(", ") + what;
  row.quantity = quantity;
  row.unit = "%";
  row.step_unit = "us";
  return row;
}

constexpr int kFinest = 384;  // sub-steps of the loop that the others are compared with
constexpr double kConverged_percent = 2;

// A light hand pushes and lets go: of all hands it gets most back from a loop, and gains most from a law that gives.
// `start`: where in its cell the tip starts.
Measurement ClosedLoop(const DeviceModel& m, haptics::LawKind law, int substeps, double start) {
  TrialSpec s = SpecOf(m, law, 6500, 0.43e-3);
  s.plant.substeps = substeps;
  s.hand = HandKind::kForce;
  s.hand_mass_kg = 0.03;
  s.direction = glm::normalize(dvec3(1, 2, 3));
  s.start_offset_m = dvec3(start) * m.resolution_m;
  s.settle_s = 1.5;
  s.window_s = 1;
  return RunTrial(s);
}

// Shares of the finest's mean. No row where that is 0: nothing converges to it.
void AddLoop(const DeviceModel& m, haptics::LawKind law, const char* quantity,
             double Measurement::*energy, std::vector<OrderRow>* out) {
  auto Of = [&](int substeps) {
    std::vector<double> all;
    for (size_t i = 0; i < kHands; ++i)
      all.push_back(ClosedLoop(m, law, substeps, static_cast<double>(i) / kHands).*energy);
    return all;
  };
  const std::vector<double> right = Of(kFinest);
  double mean = 0;
  for (double r : right) mean += r / kHands;
  if (mean == 0) return;
  const std::string what = "loop over " + std::string(haptics::FindLaw(law)->name);
  OrderRow row = Named(m, what.c_str(), quantity);
  std::vector<StepErrors> errors;
  for (int substeps : {3, 6, 12, 24, 48}) {
    errors.push_back({m.tick_s() / substeps * 1e6, Of(substeps)});
    for (size_t i = 0; i < kHands; ++i)
      errors.back().errors[i] = 100 * (errors.back().errors[i] - right[i]) / mean;
    if (Rms(errors.back().errors) > kConverged_percent)
      row.converged_from = kNotApplicable;
    else if (std::isnan(row.converged_from))
      row.converged_from = errors.back().step;
  }
  out->push_back(OrderRowOf(std::move(row), errors, true));
}

}  // namespace

std::vector<OrderRow> PlantOrders(const DeviceModel& m) {
  std::vector<StepErrors> stretch, energy;
  for (int substeps : {3, 6, 12, 24}) {
    const double step_s = kTick_s / substeps;
    for (auto* list : {&stretch, &energy}) list->push_back({step_s * 1e6, {}});
    for (size_t i = 0; i < kHands; ++i) {
      const DrawnErrors e = DrawAt(m, fidelity::kGrips_n_per_m[i], step_s);
      stretch.back().errors.push_back(e.stretch);
      energy.back().errors.push_back(e.energy);
    }
  }
  std::vector<OrderRow> out = {
      OrderRowOf(Named(m, "in a hand of 0.3 to 5 N/mm", "stretch"), stretch, true),
      OrderRowOf(Named(m, "in a hand of 0.3 to 5 N/mm", "energy"), energy, true)};
  AddLoop(m, haptics::kDefaultLaw, "energy put in", &Measurement::handed_j, &out);
  AddLoop(m, haptics::LawKind::kMaxwell, "energy given back", &Measurement::extracted_j, &out);
  return out;
}

}  // namespace enamel::station::lab
