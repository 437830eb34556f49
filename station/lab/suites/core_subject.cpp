#include <algorithm>
#include <cmath>

#include "common/core/core.h"
#include "common/scene/builder.h"
#include "common/scene/cell.h"
#include "station/lab/suites/adversary.h"

namespace enamel::station::lab {
namespace {

// A ball of a bur in a hollow that is wider by kRoom_m, so that hard and soft tissue are a few cells away in
// every direction. It comes out of the air that a start needs.
constexpr double kBur_m = 0.4e-3, kRoom_m = 60e-6, kHalf_m = 1.2e-3;
constexpr int32_t kVoxel_nm = 100'000;
constexpr int32_t kHard_mn_s_per_mm = 6500, kSoft_mn_s_per_mm = 300;
// The adversary's B above which the bur is switched off: all that it touches is wall then.
constexpr double kStill_n_s_per_m = 1e5;

// The tip is the ball's lowest point.
const dvec3 kMiddle(0, 0, kBur_m);

int32_t Nm(double m) { return static_cast<int32_t>(std::lround(m * 1e9)); }

const cutting::Volume& Hollow() {
  static const cutting::Volume volume = [] {
    const dvec3 corner(kHalf_m);
    return scene::BuildVolume(
        scene::GridAround(-corner, corner, kVoxel_nm), scene::Field([](const dvec3& p) {
          const dvec3 q = glm::abs(p) - dvec3(kHalf_m);
          const double box = std::max({q.x, q.y, q.z});
          const double hollow = kBur_m + kRoom_m - glm::length(p - kMiddle);
          return scene::FieldSample{std::max(box, hollow),
                                    p.x > 0 ? cutting::Tissue::kEnamel : cutting::Tissue::kPulp,
                                    std::fabs(p.x)};
        }));
  }();
  return volume;
}

core::CoreParams ParamsOf(const DeviceModel& m, const GameRules& rules, const Target& target) {
  const scene::DeviceProfile profile = rules.ProfileOf(m);
  const scene::TipCellNm cell = scene::TipCellOf(profile);
  core::CoreParams p;
  p.rate_hz = static_cast<uint32_t>(rules.rate_hz);
  p.law = *target.law;
  p.kc_mn_per_mm = static_cast<int32_t>(ClauseStiffness(m, rules));
  p.resolution_nm.fill(scene::CountNm(profile));
  p.cell_half_nm.fill(cell.half_nm);
  p.cell_ball_nm = cell.ball_nm;
  // Whole mN, and not more than there is.
  p.friction_mn.fill(static_cast<int32_t>(1e3 * ClauseFriction(m, rules, target)));
  p.friction_measured = true;
  p.peak_force_mn = static_cast<int32_t>(std::lround(m.peak_force_n * 1e3));
  p.bus_delay_ticks = static_cast<uint32_t>(rules.clause_ticks());
  // Until every force under way has ended, as half a second of a real attempt does.
  p.soft_start_ticks = p.bus_delay_ticks + 1;
  p.bur_shape = cutting::BurShape::kSphere;
  p.bur_radius_nm = Nm(kBur_m);
  p.damping_mn_s_per_mm.fill(kHard_mn_s_per_mm);
  p.damping_mn_s_per_mm[static_cast<size_t>(cutting::Tissue::kPulp)] = kSoft_mn_s_per_mm;
  return p;
}

class CoreSubject final : public Subject {
 public:
  CoreSubject(const DeviceModel& m, const GameRules& rules, const Target& target)
      : count_m_(rules.ProfileOf(m).cell->count_nm * 1e-9),
        core_(ParamsOf(m, rules, target), Hollow()) {}
  void Start(const dvec3& tip) override { start_ = CountsOf(tip); }
  dvec3 Step(const SubjectTick& tick) override {
    const std::array<int32_t, 3> counts = CountsOf(tick.tip_m);
    core::TickInput input;
    for (size_t i = 0; i < 3; ++i) input.counts[i] = counts[i] - start_[i];
    const Sym3& b = tick.contact.damping_n_s_per_m;
    if (b.Trace() < 3 * kStill_n_s_per_m) input.flags = core::kBurOn;
    input.bur_speed_krpm = 200;
    input.gap_ticks = static_cast<uint32_t>(tick.gap_ticks);
    const core::TickOutput out = core_.Step(input);
    const bool on = (out.flags & core::kSuspended) == 0;
    restarts_ += on && on_ && tick.gap_ticks > 0;
    restarts_ += on && !on_;
    on_ = on;
    return -out.force_sent_n;
  }
  std::optional<double> tank_j() const override { return std::nullopt; }
  int restarts() const override { return restarts_; }

 private:
  std::array<int32_t, 3> CountsOf(const dvec3& tip) const {
    std::array<int32_t, 3> out;
    for (int i = 0; i < 3; ++i)
      out[static_cast<size_t>(i)] = static_cast<int32_t>(std::floor(tip[i] / count_m_));
    return out;
  }
  double count_m_;
  core::Core core_;
  std::array<int32_t, 3> start_{};
  bool on_ = false;
  int restarts_ = 0;
};

}  // namespace

std::unique_ptr<Subject> MakeCoreSubject(const DeviceModel& m, const GameRules& rules,
                                         const Target& target) {
  return std::make_unique<CoreSubject>(m, rules, target);
}

}  // namespace enamel::station::lab
