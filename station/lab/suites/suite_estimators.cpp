#include <algorithm>
#include <chrono>
#include <cmath>

#include "station/lab/suites/suites.h"

namespace enamel::station::lab {
namespace {

struct Figures {
  double rms = 0, worst = 0, settle_s = -1, stop_s = -1, ns = 0;
};

// A quantised ramp of `speed` from rest, then a stop: error of the second half of the ramp, time
// until the error stays below a tenth after the start and after the stop, cost.
Figures Judge(const haptics::EstimatorEntry& entry, const DeviceModel& m, double speed,
              int window) {
  haptics::EstimatorParams p;
  p.kind = entry.kind;
  p.tick_s = m.tick_s();
  p.resolution_m = m.resolution_m;
  p.window_ticks = window;
  auto estimator = entry.make(p);
  int n = static_cast<int>(4 * m.rate_hz);
  std::vector<double> in(static_cast<size_t>(2 * n));
  for (int k = 0; k < 2 * n; ++k) {
    double x = speed * m.tick_s() * std::min(k, n);
    // 0.37: a start neither in the middle nor at an edge of its cell.
    in[static_cast<size_t>(k)] = (std::floor(x / m.resolution_m + 0.37) + 0.5) * m.resolution_m;
  }
  estimator->Reset(in[0]);
  Figures f;
  double squares = 0;
  auto from = std::chrono::steady_clock::now();
  std::vector<double> out(in.size());
  for (size_t k = 0; k < in.size(); ++k) out[k] = estimator->Update(in[k]);
  std::chrono::duration<double, std::nano> took = std::chrono::steady_clock::now() - from;
  f.ns = took.count() / static_cast<double>(in.size());
  for (int k = 0; k < 2 * n; ++k) {
    double off = std::fabs(out[static_cast<size_t>(k)] - (k < n ? speed : 0));
    if (k >= n / 2 && k < n) {
      squares += off * off;
      f.worst = std::max(f.worst, off);
    }
    if (off > 0.1 * speed) (k < n ? f.settle_s : f.stop_s) = (k < n ? k : k - n) * m.tick_s();
  }
  f.rms = std::sqrt(squares / (n / 2));
  return f;
}

}  // namespace

void RunEstimatorsSuite(SuiteContext& c) {
  size_t done = 0, all = c.findings.models.size() * 3;
  for (const DeviceModel& m : c.findings.models) {
    Table t;
    t.title = "Velocity estimators on " + m.title + ", quantised ramp and stop";
    t.note =
        "Error as force at B = 6.5 N s/mm. Eq. 9 bounds the one-tick difference by 2 B delta f = " +
        F(2 * 6500 * m.resolution_m * m.rate_hz, "%.0f") +
        " N. A window for 0.1 N needs B delta / 0.1 N = " + F(6500 * m.resolution_m / 0.1) + " s.";
    t.head = {"estimator",    "speed mm/s", "rms N", "max N", "last > 10 % after start s",
              "after stop s", "ns / update"};
    // A slow finish, the paper's cutting speed, and faster than anybody cuts enamel.
    for (double speed : {0.05e-3, 0.43e-3, 2e-3}) {
      for (const auto& entry : haptics::VelocityEstimators()) {
        Figures f = Judge(entry, m, speed, 256);
        t.rows.push_back({std::string(entry.name), F(speed * 1e3, "%.2f"), F(6500 * f.rms),
                          F(6500 * f.worst), F(f.settle_s), F(f.stop_s), F(f.ns, "%.0f")});
      }
      c.progress("estimators", ++done, all);
    }
    c.findings.tables.push_back(std::move(t));
  }
}

}  // namespace enamel::station::lab
