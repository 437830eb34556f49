#include <cmath>

#include "common/haptics/uniform_material.h"
#include "station/lab/suites/adversary.h"

namespace enamel::station::lab {
namespace {

using haptics::Contact;
using haptics::LawKind;

class CouplingSubject final : public Subject {
 public:
  CouplingSubject(const DeviceModel& m, const GameRules& rules, LawKind law)
      : coupling_(Params(m, rules, law)) {}
  void Reset(const dvec3& tip) override { coupling_.Reset(tip); }
  void Resume(const dvec3& tip) override {
    if (!coupling_.Resume(tip, material_)) coupling_.Reset(tip);
  }
  dvec3 Tick(const dvec3& tip, double bound_ratio, const Contact& contact, const dvec3&) override {
    material_.contact = contact;
    haptics::CouplingOutput out = coupling_.Tick(tip, bound_ratio, material_);
    tank_j_ = out.tank_j;
    // The coupling gives the force on the operator; the theorem is about the resisting one.
    return -out.force_sent_n;
  }
  double tank_j() const override { return tank_j_; }

 private:
  static haptics::CouplingParams Params(const DeviceModel& m, const GameRules& rules, LawKind law) {
    haptics::CouplingParams p;
    p.law.kind = law;
    p.law.kc_n_per_m = ClauseStiffness(m, rules);
    p.law.tick_s = m.tick_s();
    p.peak_force_n = m.peak_force_n;
    p.law.resolution_m = dvec3(m.resolution_m);
    p.cell = rules.Cell(m.resolution_m);
    // Exactly the delay of the rules, for which it is proved.
    p.delay_ticks = rules.clause_ticks();
    return p;
  }
  haptics::Coupling coupling_;
  haptics::UniformMaterial material_;
  double tank_j_ = 0;
};

// The guard without a law. The adversary requests what a law could do at worst, so a pump found
// here exists in every law that moves its rest point by guarded steps.
class GuardedSpring final : public Subject {
 public:
  GuardedSpring(const DeviceModel& m, const GameRules& rules, double energy)
      : kc_(ClauseStiffness(m, rules)), tick_(m.tick_s()), peak_(m.peak_force_n) {
    params_.kc_n_per_m = kc_;
    params_.cell = rules.Cell(m.resolution_m);
    params_.delay_ticks = rules.clause_ticks();
    tank_.energy_j = energy;
    // The spring's energy at half the peak force, (F/2)^2/(2 Kc): enough to be worth stealing.
    tank_.cap_j = 0.125 * peak_ * peak_ / kc_;
    tank_.inflow_share = 0.3;
  }
  void Reset(const dvec3& tip) override {
    tip_ = rest_ = tip;
    share_ = 1;
    sent_ = dvec3(0);
  }
  void Resume(const dvec3& tip) override {
    dvec3 e = tip - rest_;
    Reset(tip);
    params_.kc_n_per_m = kc_;
    tank_.BeginTick();
    resumed_ = true;  // the next tick's steps are of the same tick
    rest_ -= e * haptics::ResumedShare(params_, e, 0, tank_);
  }
  dvec3 Tick(const dvec3& tip, double bound_ratio, const Contact& contact,
             const dvec3& push) override {
    // From quantised positions, hence wrong by a cell. The proof does not use it; it bounds the
    // inflow.
    double work = Dot(sent_, tip - tip_);
    tip_ = tip;
    if (!resumed_) tank_.BeginTick();
    resumed_ = false;
    Move(push, work);
    dvec3 e = tip_ - rest_;
    Sym3 b = contact.damping_n_s_per_m;
    // The implicit Maxwell step (B + Kc T)^-1 Kc T e: bounded for every B, however small.
    dvec3 w = e - b * SolveShifted(b, kc_ * tick_, e);
    double into = Dot(w, contact.wall_normal);
    if (into > 0) w -= contact.wall_normal * into;
    Move(w, work);
    double bound = peak_ * bound_ratio;
    e = tip_ - rest_;
    // As in the coupling: the rest point yields first, the rest is a share of the stiffness.
    double force = kc_ * std::sqrt(Dot(e, e));
    if (force > bound) Move(e * (1 - bound / force), work);
    params_.kc_n_per_m = kc_;
    share_ = haptics::StiffnessShare(params_, tip_ - rest_, bound, share_, tank_);
    sent_ = (tip_ - rest_) * (kc_ * share_);
    return sent_;
  }
  double tank_j() const override { return tank_.energy_j; }

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
                                     std::optional<LawKind> law, double energy) {
  if (law) return std::make_unique<CouplingSubject>(m, rules, *law);
  return std::make_unique<GuardedSpring>(m, rules, energy);
}

}  // namespace enamel::station::lab
