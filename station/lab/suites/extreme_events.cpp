#include <algorithm>
#include <cmath>
#include <limits>

#include "common/cutting/voxel_limit.h"
#include "station/lab/cutting/force_error.h"
#include "station/lab/suites/extreme_cases.h"

namespace enamel::station::lab {
namespace {

constexpr double kSpeed_m_per_s = 0.43e-3, kEnamel_n_s_per_m = 6500;
// Of forces that are computed to be 0, N.
constexpr double kNone_n = 1e-9;

class StepMaterial final : public haptics::Material {
 public:
  haptics::Contact ContactAt(const dvec3&, const dvec3&) noexcept override {
    haptics::Contact c;
    c.damping_n_s_per_m = b;
    c.engaged = !b.IsZero();
    c.clearance_m = 1;
    return c;
  }
  void AnchorMoved(const dvec3&, const dvec3&) noexcept override {}
  Sym3 b = Sym3::Isotropic(kEnamel_n_s_per_m);
};

using Script = std::function<dvec3(int, StepMaterial&)>;

struct Forces {
  double most_n = 0, last_n = 0;
  double after_n = 0;  // largest from tick kEvent on
  bool finite = true;
};
constexpr int kEvent = 4000;

// The coupling's forces along a path of tips.
Forces Drive(const DeviceModel& m, int ticks, const Script& tip) {
  haptics::CouplingParams p;
  p.law = SpecOf(m, haptics::kDefaultLaw, kEnamel_n_s_per_m, kSpeed_m_per_s).law;
  p.peak_force_n = m.peak_force_n;
  haptics::Coupling coupling(p);
  StepMaterial material;
  Forces out;
  for (int k = 0; k < ticks; ++k) {
    const dvec3 at = tip(k, material);
    if (k == 0) coupling.Reset(at);
    const double f = glm::length(coupling.Tick(at, 1, material).force_sent_n);
    out.finite = out.finite && std::isfinite(f);
    out.most_n = std::max(out.most_n, f);
    out.last_n = f;
    if (k > kEvent) out.after_n = std::max(out.after_n, f);
  }
  return out;
}

enum class Bound { kNoForceAfter, kPeakAtMost, kPeakAtEnd, kLetsGo, kNoForce };

ExtremeRow RowOf(const DeviceModel& m, const char* name, Bound bound, const Forces& f) {
  ExtremeRow row;
  row.name = name;
  row.device = m.name;
  row.unit = "N";
  row.within_peak = f.finite && f.most_n <= m.peak_force_n * (1 + 1e-9);
  switch (bound) {
    case Bound::kNoForceAfter:
      row.quantity = "largest force from the event on";
      row.found = f.after_n;
      row.most = kNone_n;
      break;
    case Bound::kPeakAtMost:
      row.quantity = "largest force";
      row.found = f.most_n;
      row.most = m.peak_force_n * (1 + 1e-9);
      break;
    case Bound::kPeakAtEnd:
      row.quantity = "force at the end";
      row.found = f.last_n;
      row.least = 0.99 * m.peak_force_n;
      row.most = m.peak_force_n * (1 + 1e-9);
      break;
    case Bound::kLetsGo:
      // What the guard may leave on each of three axes.
      row.quantity = "force at the end";
      row.found = f.last_n;
      row.most = std::sqrt(3.0) * m.kc_n_per_m * m.resolution_m / 2;
      break;
    case Bound::kNoForce:
      row.quantity = "largest force";
      row.found = f.most_n;
      row.most = kNone_n;
      break;
  }
  return row;
}

}  // namespace

void AddEvents(const DeviceModel& m, std::vector<ExtremeRow>* rows) {
  const double v = kSpeed_m_per_s * m.tick_s(), delta = m.resolution_m;
  // Two axes at different speeds, so that counts do not coincide.
  auto Steady = [=](int k) { return CellMiddle(dvec3(v * k, 0.3 * v * k, 0), delta); };
  const double nan = std::numeric_limits<double>::quiet_NaN(),
               inf = std::numeric_limits<double>::infinity();
  auto Add = [&](const char* name, Bound bound, int ticks, const Script& script) {
    rows->push_back(RowOf(m, name, bound, Drive(m, ticks, script)));
  };
  auto During = [](int k, int ticks) { return k > kEvent && k <= kEvent + ticks; };
  Add("position NaN for 5 ticks", Bound::kNoForceAfter, 8000,
      [&](int k, StepMaterial&) { return During(k, 5) ? dvec3(nan) : Steady(k); });
  Add("position infinite for 5 ticks", Bound::kNoForceAfter, 8000,
      [&](int k, StepMaterial&) { return During(k, 5) ? dvec3(inf, 0, 0) : Steady(k); });
  Add("material NaN for 100 ticks", Bound::kNoForceAfter, 8000, [&](int k, StepMaterial& s) {
    s.b = During(k, 100) ? Sym3::Isotropic(nan) : Sym3::Isotropic(kEnamel_n_s_per_m);
    return Steady(k);
  });
  Add("position jumps by 5 mm for one tick", Bound::kPeakAtMost, 8000, [&](int k, StepMaterial&) {
    return Steady(k) + (k == kEvent ? dvec3(5e-3, 0, 0) : dvec3(0));
  });
  Add("counts wrap at 16 bit", Bound::kPeakAtMost, 8000, [&](int k, StepMaterial&) {
    return Steady(k) - (k > kEvent ? dvec3(65536 * delta, 0, 0) : dvec3(0));
  });
  // Five time constants of the slowest spring there is, on top of the event's four seconds.
  const int enough = kEvent + static_cast<int>(10 * kEnamel_n_s_per_m / m.kc_n_per_m * m.rate_hz);
  Add("clock stands still: no counts", Bound::kLetsGo, enough,
      [&](int k, StepMaterial&) { return Steady(std::min(k, kEvent)); });
  Add("air, enamel, dentin, pulp in turn", Bound::kPeakAtMost, 12000, [&](int k, StepMaterial& s) {
    constexpr double kLayers[] = {0, 8700, 5200, 300};
    s.b = Sym3::Isotropic(kLayers[(k / 1000) % 4]);
    return Steady(k);
  });
  Add("pushed 20 mm into stone (B = 1e6 N s/mm)", Bound::kPeakAtEnd, 8000,
      [&](int k, StepMaterial& s) {
        s.b = Sym3::Isotropic(1e9);
        return CellMiddle(dvec3(5e-6 * std::min(k, kEvent), 0, 0), delta);
      });
  Add("B = 0", Bound::kNoForce, 4000, [&](int k, StepMaterial& s) {
    s.b = Sym3{};
    return Steady(k);
  });
}

void AddVoxelLimits(std::vector<ExtremeRow>* rows) {
  for (const CutCase& c : BurCases()) {
    const int32_t voxel_nm = cutting::LargestVoxel_nm(c.bur);
    ExtremeRow row;
    row.name = "largest voxel of a " + std::string(cutting::BurShapeName(c.bur.shape)) + ", " +
               std::to_string(voxel_nm / 1000) + " um";
    row.quantity = "force off B v, RMS over ways to travel";
    row.unit = "%";
    row.most = 100 * cutting::kMaxVoxelForceError;
    row.found = 100 * MeasureForceError(c.bur, voxel_nm);
    row.within_peak = true;
    rows->push_back(row);
  }
}

}  // namespace enamel::station::lab
