#include "station/lab/laws/stability.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "common/fidelity/hands.h"

namespace enamel::station::lab {
namespace {

// One axis of either rendering.
class Controller {
 public:
  Controller(Rendered what, double gain, double tick_s, const dvec3& start_m)
      : gain_(what == Rendered::kSpring ? gain : gain / tick_s),
        damper_(what == Rendered::kDamper),
        previous_(start_m) {}
  dvec3 Force(const dvec3& p) {
    dvec3 force = -gain_ * (damper_ ? p - previous_ : p);
    previous_ = p;
    return dvec3(force.x, 0, 0);
  }

 private:
  double gain_;
  bool damper_;
  dvec3 previous_;
};

double Bisect(double low, double high, const std::function<bool(double)>& holds) {
  if (holds(high)) return high;
  for (int i = 0; i < 26; ++i) {
    // Geometric, because gains range over ten decades: 26 halvings leave a ratio of 1 + 4e-7.
    double mid = std::sqrt(low * high);
    (holds(mid) ? low : high) = mid;
  }
  return low;
}

// The operator's work over the later half of `cycles` cycles, including the plant's b and c. Below
// zero: the operator gains it in every further cycle.
double WorkOfLaterCycles(const PlantSpec& spec, Rendered what, double gain, double amplitude_m,
                         int period) {
  constexpr int kCycles = 24;
  std::vector<dvec3> way;
  for (int k = 0; k <= kCycles * period + 1; ++k)
    way.push_back(dvec3(amplitude_m * std::cos(2 * M_PI * k / period), 0, 0));
  ScriptedHand hand(way, spec.tick_s);
  Plant plant(spec, hand, way[0]);
  Controller controller(what, gain, spec.tick_s, plant.Read());
  double work = 0;
  for (int k = 0; k < kCycles * period; ++k) {
    double before = plant.tip_m().x;
    plant.Step(controller.Force(plant.Read()));
    double dx = plant.tip_m().x - before;
    if (k < kCycles / 2 * period) continue;
    work += -plant.sent_n().x * dx + spec.damping_n_s_per_m / spec.tick_s * dx * dx +
            spec.friction_n * std::fabs(dx);
  }
  return work;
}

bool GainsNothing(const PlantSpec& spec, Rendered what, double gain) {
  // Two ticks is the fastest that a sampled loop can be shaken.
  for (int period : {2, 3, 4, 6, 10, 20}) {
    // Within a cell, across one edge, across several, and so far that cells do not matter.
    for (double cells : {0.002, 0.4, 1.3, 10.3, 1e4}) {
      double work = WorkOfLaterCycles(spec, what, gain, cells * spec.resolution_m, period);
      if (work < 0) return false;
    }
  }
  return true;
}

// Whether the swing in the second half is smaller than in the first, or only some cells.
bool ComesToRest(const PlantSpec& spec, Rendered what, double gain, const Hold& hold) {
  constexpr double kStart_m = 1e-3, kRun_s = 2;
  LineMotion still;
  ImpedanceHand hand(still, hold.stiffness_n_per_m, hold.mass_kg, hold.damping_n_s_per_m);
  Plant plant(spec, hand, dvec3(kStart_m, 0, 0));
  // A damper has no rest position: it starts from one false count, 1 mm in a tick.
  Controller controller(what, gain, spec.tick_s,
                        what == Rendered::kDamper ? dvec3(0) : plant.Read());
  int ticks = static_cast<int>(kRun_s / spec.tick_s);
  double early = 0, late = 0, most = 0;
  for (int k = 0; k < ticks; ++k) {
    plant.Step(controller.Force(plant.Read()));
    double speed = plant.speed_m_per_s().x;
    if (!(std::fabs(speed) < 1e3)) return false;
    most = std::max(most, std::fabs(speed));
    double& half = k < ticks / 2 ? early : late;
    if (k >= ticks / 4) half = std::max(half, std::fabs(speed));
  }
  // Speed, not position: a device alone rests anywhere. A thirtieth of a cell a tick, or a
  // millionth of the first swing, counts as rest.
  return late < early || late < std::max(spec.resolution_m / spec.tick_s / 30, 1e-6 * most);
}

}  // namespace

double LargestPassive(const PlantSpec& plant, Rendered what) {
  return Bisect(1e-3, 1e7, [&](double gain) { return GainsNothing(plant, what, gain); });
}

double LargestStable(const PlantSpec& plant, Rendered what, const Hold& hold) {
  return Bisect(1e-3, 1e7, [&](double gain) { return ComesToRest(plant, what, gain, hold); });
}

// x' = x + alpha v + a u, v' = e v + g u over a tick, u held; with u = -K x the poles are those of
// z^2 - (1 + e - K a) z + e + K (alpha g - e a), inside the circle until the last term is 1.
double LinearStableSpring(double m, double b, double tick) {
  double e = std::exp(-b * tick / m), alpha = m / b * (1 - e), a = (tick - alpha) / b,
         g = (1 - e) / b;
  double by_product = (1 - e) / (alpha * g - e * a);
  double slack = a * (1 + e) - alpha * g;  // 2 (1 + e) - K slack > 0: no pole at -1
  return slack > 0 ? std::min(by_product, 2 * (1 + e) / slack) : by_product;
}

// With u = -B (x - x before) / T the state is (v, difference): the product of its poles is
// B (g alpha - e a) / T, their sum e - a B / T.
double LinearStableDamper(double m, double b, double tick) {
  double e = std::exp(-b * tick / m), alpha = m / b * (1 - e), a = (tick - alpha) / b,
         g = (1 - e) / b;
  double by_product = tick / (g * alpha - e * a);
  double slack = (a * (1 + e) - g * alpha) / tick;  // 1 + e - B slack > 0: no pole at -1
  return slack > 0 ? std::min(by_product, (1 + e) / slack) : by_product;
}

}  // namespace enamel::station::lab
