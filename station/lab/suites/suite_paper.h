#pragma once

#include <string>
#include <vector>

#include "station/lab/suites/findings.h"

// Tests Table 3 of Liu et al. 2008 (3.7 / 0.8 / 1.1 N "maximum continuous output force" at more
// than 2 mm/s) in simulation and by its own arithmetic. SI units. Thread safety: any thread.
namespace enamel::station::lab {

// Implications of one printed force.
struct Table3Says {
  double way_m = 0;                         // F / Kc: what eq. 17 needs to get there, and passes
  double time_s = 0;                        // that way at 2 mm/s
  double largest_b_n_s_per_m = 0;           // F / V at 2 mm/s: a larger B asks for more than F
  double largest_b_of_count_n_s_per_m = 0;  // F T / delta: the same for one tick's difference,
                                            // whose least speed is one count a tick
  double force_at_figure_8_n = 0;  // largest_b at 0.4 mm/s; figure 8 shows 2.6 N within 0.1 N
};
Table3Says ArithmeticOfTable3(double force_n, double kc_n_per_m, double resolution_m,
                              double tick_s);

// Possible readings of eq. 17.
struct LimiterReading {
  const char* label;
  haptics::LawKind law;
  haptics::EstimatorKind estimator;
  int window_ticks;
  bool pass_through_at_rest;
};
std::vector<LimiterReading> LimiterReadings();

// Resisting force, N, of eq. 17 (held where dp = 0, B 6.5 N s/mm) under a hand that prescribes
// 2 mm/s, after that way.
double LimiterForceAfter(const DeviceModel& model, double way_m);

// The paper's experiment: a hand of 1 N/mm moves at `speed` for 1 s while B is raised from 0.005 to
// 6.5 N s/mm in steps of a seventh until the device vibrates (more than 0.1 N rms above 20 Hz, or
// the operator gains over 10 uJ). Largest force of the runs before it.
struct RaisedDamping {
  double force_n = 0, b_n_s_per_m = 0;
  bool vibrated = false;  // false: B reached 6.5 without
};
RaisedDamping RaiseUntilItVibrates(const DeviceModel& model, const LimiterReading& reading,
                                   double speed_m_per_s);

// Largest over least of printed / quantity over the three devices: 1 where the printed forces are
// in proportion to it. In the order of Printed: Omega, Phantom Desktop, BHhd.
double SpreadOf(const std::vector<double>& printed, const std::vector<double>& quantity);

}  // namespace enamel::station::lab
