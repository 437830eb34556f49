#include "station/lab/laws/approach.h"

#include <algorithm>
#include <cmath>

#include "common/haptics/coupling.h"
#include "station/lab/laws/half_space.h"

namespace enamel::station::lab {
namespace {

constexpr double kFelt_n = 0.1, kBack_m = 3e-3, kCutOn_s = 2, kWithdraw_m_per_s = 30e-3;

}  // namespace

ApproachFigures RunApproach(const DeviceModel& m, const Approach& a) {
  const TrialSpec spec = SpecOf(m, a.law, a.b_n_s_per_m, 0);
  haptics::CouplingParams params;
  params.law = spec.law;
  params.peak_force_n = spec.peak_force_n;
  haptics::Coupling coupling(params);
  HalfSpace tissue(a.b_n_s_per_m, 1e-6);
  const double tick_s = m.tick_s();
  double at = 0;
  // Off the middle of a cell on every axis, differently.
  auto Read = [&] {
    return fidelity::CellMiddle(HalfSpace::kInward * at + dvec3(3.3e-6, 2.1e-6, 1.1e-6),
                                m.resolution_m);
  };
  auto StepBy = [&](double speed) {
    at += speed * tick_s;
    return coupling.Tick(Read(), 1, tissue);
  };
  coupling.Reset(Read());
  // Until the plain spring has settled to a tenth.
  const double first_s = 1 + 2.3 * a.b_n_s_per_m / m.kc_n_per_m;
  for (double t = 0; t < first_s; t += tick_s) StepBy(a.cut_m_per_s);
  // From a place that no law decides: at 50 mm/s a tick is 50 um, and where in a tick the surface is met
  // would be the way that is measured.
  if (a.goes_on) tissue.Retreat(std::ceil(tissue.surface_m() / kBack_m) * kBack_m);
  const double begin = tissue.surface_m();
  while (at > begin - kBack_m) StepBy(-kWithdraw_m_per_s);
  if (a.goes_on) {
    at = begin - kBack_m;
    StepBy(0);
  }
  tissue.wall = a.wall;
  ApproachFigures out;
  while (at + a.speed_m_per_s * tick_s < begin) {
    const haptics::CouplingOutput tick = StepBy(a.speed_m_per_s);
    out.behind_m = std::max(out.behind_m, glm::length(tick.anchor_m - Read()));
  }
  const double speed = a.goes_on ? a.speed_m_per_s : a.cut_m_per_s;
  for (double t = 0; t < kCutOn_s; t += tick_s) {
    const double r = -Dot(StepBy(speed).force_sent_n, HalfSpace::kInward);
    if (!a.goes_on) {
      out.excess_n = std::max(out.excess_n, r - a.b_n_s_per_m * a.cut_m_per_s);
    } else if (r >= kFelt_n) {
      out.way_m = std::max(0.0, at - begin);
      break;
    }
  }
  return out;
}

}  // namespace enamel::station::lab
