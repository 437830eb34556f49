#include <cmath>

#include "common/haptics/uniform_material.h"
#include "station/lab/suites/adversary.h"

namespace enamel::station::lab {
namespace {

using haptics::LawKind;

// The order of core::Core::Step around a coupling, at a tenth of its cost and with any material.
// Suspended, the force stays off until the bur has been in air, and every force under way has ended.
class OrderedSubject : public Subject {
 public:
  explicit OrderedSubject(int delay_ticks) : delay_ticks_(delay_ticks) {}
  void Start(const dvec3& tip) final { Reset(tip); }
  dvec3 Step(const SubjectTick& tick) final {
    const bool lost =
        tick.gap_ticks > 0 && (suspended_ || tick.gap_ticks <= delay_ticks_ || !Resume(tick.tip_m));
    if (!lost && !suspended_) {
      restarts_ += tick.gap_ticks > 0;
      return Tick(tick);
    }
    Reset(tick.tip_m);
    free_ticks_ = lost || tick.contact.engaged ? 0 : free_ticks_ + 1;
    suspended_ = free_ticks_ <= delay_ticks_;
    restarts_ += !suspended_;
    return dvec3(0);
  }
  int restarts() const final { return restarts_; }

 protected:
  virtual void Reset(const dvec3& tip) = 0;
  [[nodiscard]] virtual bool Resume(const dvec3& tip) = 0;
  virtual dvec3 Tick(const SubjectTick& tick) = 0;

 private:
  int delay_ticks_, free_ticks_ = 0, restarts_ = 0;
  bool suspended_ = false;
};

class CouplingSubject final : public OrderedSubject {
 public:
  CouplingSubject(const DeviceModel& m, const GameRules& rules, const Target& target)
      : OrderedSubject(rules.clause_ticks()), coupling_(Params(m, rules, target)) {}
  std::optional<double> tank_j() const override { return coupling_.tank_j(); }
  std::optional<double> stored_j(const dvec3& x) const override {
    const dvec3 stretch = x - coupling_.rest_m();
    return 0.5 * coupling_.stiffness_n_per_m() * Dot(stretch, stretch);
  }

 protected:
  void Reset(const dvec3& tip) override { coupling_.Reset(tip); }
  bool Resume(const dvec3& tip) override { return coupling_.Resume(tip, material_); }
  dvec3 Tick(const SubjectTick& tick) override {
    material_.contact = tick.contact;
    material_.load = tick.load;
    material_.drag_n = tick.drag_n;
    // The coupling gives the force on the operator; the theorem is about the resisting one.
    return -coupling_.Tick(tick.tip_m, tick.bound_ratio, material_).force_sent_n;
  }

 private:
  static haptics::CouplingParams Params(const DeviceModel& m, const GameRules& rules,
                                        const Target& target) {
    haptics::CouplingParams p;
    p.law.kind = *target.law;
    p.law.kc_n_per_m = ClauseStiffness(m, rules);
    p.law.tick_s = m.tick_s();
    p.peak_force_n = m.peak_force_n;
    p.law.resolution_m = dvec3(m.resolution_m);
    p.cell = CellUnder(m, rules);
    p.friction = {dvec3(ClauseFriction(m, rules, target)), true};
    // Exactly the delay of the rules, for which it is proved.
    p.delay_ticks = rules.clause_ticks();
    return p;
  }
  haptics::Coupling coupling_;
  haptics::UniformMaterial material_;
};

// The guard without a law. The adversary requests what a law could do at worst, so a pump found
// here exists in every law that moves its rest point by guarded steps.
class GuardedSpring final : public OrderedSubject {
 public:
  GuardedSpring(const DeviceModel& m, const GameRules& rules, double energy)
      : OrderedSubject(rules.clause_ticks()),
        kc_(ClauseStiffness(m, rules)),
        tick_(m.tick_s()),
        peak_(m.peak_force_n) {
    params_.kc_n_per_m = kc_;
    params_.cell = CellUnder(m, rules);
    params_.delay_ticks = rules.clause_ticks();
    tank_.energy_j = energy;
    // The spring's energy at half the peak force, (F/2)^2/(2 Kc): enough to be worth stealing.
    tank_.cap_j = 0.125 * peak_ * peak_ / kc_;
    tank_.inflow_share = 0.3;
  }
  std::optional<double> tank_j() const override { return tank_.energy_j; }

 protected:
  void Reset(const dvec3& tip) override {
    tip_ = rest_ = tip;
    share_ = 1;
    sent_ = dvec3(0);
  }
  bool Resume(const dvec3& tip) override {
    dvec3 e = tip - rest_;
    Reset(tip);
    params_.kc_n_per_m = kc_;
    tank_.BeginTick();
    resumed_ = true;  // the next tick's steps are of the same tick
    rest_ -= e * haptics::ResumedShare(params_, e, 0, tank_);
    return true;
  }
  dvec3 Tick(const SubjectTick& tick) override {
    // From quantised positions, hence wrong by a cell. The proof does not use it; it bounds the
    // inflow.
    double work = Dot(sent_, tick.tip_m - tip_);
    tip_ = tick.tip_m;
    if (!resumed_) tank_.BeginTick();
    resumed_ = false;
    Move(tick.push_m, work);
    dvec3 e = tip_ - rest_;
    Sym3 b = tick.contact.damping_n_s_per_m;
    // The implicit Maxwell step (B + Kc T)^-1 Kc T e: bounded for every B, however small.
    dvec3 w = e - b * SolveShifted(b, kc_ * tick_, e);
    double into = Dot(w, tick.contact.wall_normal);
    if (into > 0) w -= tick.contact.wall_normal * into;
    Move(w, work);
    double bound = peak_ * tick.bound_ratio;
    e = tip_ - rest_;
    // As in the coupling: the rest point yields first, the rest is a share of the stiffness.
    double force = kc_ * std::sqrt(Dot(e, e));
    if (force > bound) Move(e * (1 - bound / force), work);
    params_.kc_n_per_m = kc_;
    share_ = haptics::StiffnessShare(params_, tip_ - rest_, bound, share_, tank_);
    sent_ = (tip_ - rest_) * (kc_ * share_);
    return sent_;
  }

 private:
  void Move(const dvec3& w, double work) {
    params_.kc_n_per_m = kc_ * share_;
    rest_ += w * haptics::GuardedStep(params_, tip_ - rest_, w, work, tank_);
  }
  double kc_, tick_, peak_;
  haptics::GuardParams params_;
  haptics::Tank tank_;
  dvec3 tip_{0}, rest_{0}, sent_{0};
  double share_ = 1;
  bool resumed_ = false;
};
}  // namespace

std::unique_ptr<Subject> MakeSubject(const DeviceModel& m, const GameRules& rules,
                                     const Target& target, double energy) {
  if (!target.law) return std::make_unique<GuardedSpring>(m, rules, energy);
  if (target.core) return MakeCoreSubject(m, rules, target);
  return std::make_unique<CouplingSubject>(m, rules, target);
}

}  // namespace enamel::station::lab
