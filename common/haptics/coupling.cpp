#include "common/haptics/coupling.h"

#include <cmath>

#include "common/math/order.h"

namespace enamel::haptics {
namespace {

// Less than this share of what resisted before is a way out.
constexpr double kWayOut = 0.3;
// For so long it counts what resisted before, s.
constexpr double kHeld_s = 0.05;
// Share of B that counts as none, in B (B + share tr B I)^-1: what is left of a way where B resists.
constexpr double kFree = 1e-9;

bool Finite(const dvec3& v) noexcept {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

// Whether b points where a does: the square of the cosine between them is above `least`.
bool SameWay(const dvec3& a, const dvec3& b, double least) noexcept {
  double along = Dot(a, b);
  return along > 0 && along * along > least * Dot(a, a) * Dot(b, b);
}

// Takes from a step what goes into a wall; whether it did.
bool StopAt(const dvec3& wall_normal, dvec3& step) noexcept {
  double into = Dot(step, wall_normal);
  if (!(into > 0)) return false;
  step -= wall_normal * into;
  return true;
}

// The part of stretch e that moves the bur: what its force is beyond Coulomb's part, and none below
// the threshold.
dvec3 BeyondCoulomb(const dvec3& e, const Contact& contact, double kc) noexcept {
  if (!(contact.coulomb_n > 0) && !(contact.threshold_n > 0)) return e;
  double force = kc * std::sqrt(Dot(e, e));
  if (!(force > contact.coulomb_n) || force < contact.threshold_n) return dvec3(0);
  return e * (1 - contact.coulomb_n / force);
}

}  // namespace

double GuardFactor(const dvec3& e, const dvec3& w, const dvec3& delta) noexcept {
  double w2 = Dot(w, w);
  if (!(w2 > 0)) return 0;
  double cell =
      0.5 * (delta.x * std::fabs(w.x) + delta.y * std::fabs(w.y) + delta.z * std::fabs(w.z));
  double factor = 2 * (Dot(e, w) - cell) / w2;
  if (!(factor > 0)) return 0;
  return factor < 1 ? factor : 1;
}

Coupling::Coupling(const CouplingParams& params) : params_(params) {
  const LawEntry* entry = FindLaw(params.law.kind);
  ENAMEL_CHECK(entry != nullptr);
  law_ = entry->make(params.law);
  guard_.kc_n_per_m = params.law.kc_n_per_m;
  guard_.cell = params.cell.Radius() > 0 ? params.cell : CartesianCell(params.law.resolution_m);
  guard_.delay_ticks = params.delay_ticks;
  // Enough to turn half of the peak force around; empty at the start, so that the floor is -V_0.
  double half = 0.5 * params.peak_force_n;
  tank_.cap_j = params.law.kc_n_per_m > 0 ? 0.5 * half * half / params.law.kc_n_per_m : 0;
  tank_.inflow_share = 1;
}

void Coupling::Reset(const dvec3& tip_m) noexcept {
  anchor_ = rest_ = tip_ = tip_m;
  resisted_ = held_ = 0;
  share_ = 1;
  stretch_ = 0;
  clipped_at_n_ = -1;
  wall_ = false;
  latched_ = false;
  law_->Reset(tip_m);
}

void Coupling::VisitState(StateArchive& archive) {
  archive(anchor_, rest_, tip_, resisted_, held_, tank_, share_, stretch_, clipped_at_n_, wall_,
          latched_);
  law_->VisitState(archive);
}

bool Coupling::Resume(const dvec3& tip_m, Material& material) noexcept {
  if (latched_ || !Finite(tip_m)) return false;
  dvec3 e = tip_m - anchor_;
  double length = std::sqrt(Dot(e, e)), grown = length - stretch_;
  if (grown > params_.max_step_m) return false;
  law_->Reset(tip_m);
  if (law_->slips()) {
    tank_.BeginTick();
    dvec3 stretch = tip_m - rest_;
    rest_ = tip_m - stretch * ResumedShare(guard_, stretch, 0, tank_);
    tip_ = tip_m;
    if (!(grown > 0)) return true;
    dvec3 to = anchor_ + e * (grown / length);
    material.AnchorMoved(anchor_, to);
    anchor_ = to;
    return true;
  }
  if (!(grown > 0)) return true;
  if (law_->anchored()) {
    CouplingOutput unused;
    MoveAnchor(tip_m, e * (grown / length), material, unused);
  } else {
    material.AnchorMoved(anchor_, tip_m);
    anchor_ = tip_m;
  }
  return true;
}

CouplingOutput Coupling::Tick(const dvec3& tip_m, double bound_ratio, Material& material) noexcept {
  CouplingOutput out;
  if (!Finite(tip_m) || !std::isfinite(bound_ratio)) {
    latched_ = true;
    out.flags = kNonFiniteInput;
  }
  if (latched_) {
    out.flags |= kLatched;
    out.anchor_m = anchor_;
    return out;
  }
  double bound_n = params_.peak_force_n * (bound_ratio < 0 ? 0 : bound_ratio > 1 ? 1 : bound_ratio);
  if (clipped_at_n_ >= 0 && bound_n > clipped_at_n_) bound_n = clipped_at_n_;
  clipped_at_n_ = -1;
  law_->BeginTick(tip_m);
  wall_ = false;
  tank_.BeginTick();
  if (law_->slips()) {
    TickSlipping(tip_m, bound_n, material, out);
  } else if (law_->anchored()) {
    RelaxAnchor(tip_m, material, out);
    out.force_computed_n = (anchor_ - tip_m) * params_.law.kc_n_per_m;
    BoundMagnitude(tip_m, bound_n, wall_, material, out);
  } else {
    Contact contact = material.ContactAt(tip_m, tip_m - anchor_);
    if (!contact.damping_n_s_per_m.IsFinite()) out.flags |= kNonFiniteInput;
    out.force_computed_n = -law_->TipForce(contact.damping_n_s_per_m);
    material.AnchorMoved(anchor_, tip_m);
    anchor_ = tip_m;
    if (!contact.engaged) out.flags |= kFreeAir;
    // No anchor to move: clip.
    BoundMagnitude(tip_m, bound_n, true, material, out);
  }
  if (!Finite(out.force_sent_n)) out.flags |= kNonFiniteInput;
  if (out.flags & kNonFiniteInput) {
    latched_ = true;
    out.flags |= kLatched;
    out.force_computed_n = out.force_sent_n = dvec3(0);
  }
  dvec3 stretch = tip_m - anchor_;
  stretch_ = std::sqrt(Dot(stretch, stretch));
  out.anchor_m = anchor_;
  return out;
}

// Spends the tick's time T moving the anchor toward the tip. Contact is read again after every
// max_step. So an air step stops at the first contact, or a step at a layer boundary, and the rest
// of the tick is spent in the material found there.
void Coupling::RelaxAnchor(const dvec3& tip_m, Material& material, CouplingOutput& out) noexcept {
  double left_s = params_.law.tick_s;
  for (int i = 0; i < params_.max_substeps; ++i) {
    dvec3 e = tip_m - anchor_;
    if (Dot(e, e) == 0) return;
    Contact contact = material.ContactAt(anchor_, e);
    if (!contact.damping_n_s_per_m.IsFinite()) {
      out.flags |= kNonFiniteInput;
      return;
    }
    dvec3 w = e - law_->Relax(e, contact.damping_n_s_per_m, left_s);
    double into = Dot(w, contact.wall_normal);
    if (into > 0) {
      w -= contact.wall_normal * into;
      wall_ = true;
      out.flags |= kWallContact;
    }
    double length = std::sqrt(Dot(w, w));
    double step_limit =
        contact.clearance_m > params_.max_step_m ? contact.clearance_m : params_.max_step_m;
    bool whole = length <= step_limit;
    if (!whole) w *= step_limit / length;
    ++out.substeps;
    dvec3 taken = MoveAnchor(tip_m, w, material, out);
    if (whole) {
      if (!contact.engaged) out.flags |= kFreeAir;
      return;
    }
    if (Dot(taken, taken) == 0) return;
    left_s -= left_s * (step_limit / length);
  }
  out.flags |= kSubstepLimit;
}

dvec3 Coupling::MoveAnchor(const dvec3& tip_m, dvec3 w, Material& material,
                           CouplingOutput& out) noexcept {
  if (Dot(w, w) == 0) return dvec3(0);
  double factor = guard_.delay_ticks == 0
                      ? GuardFactor(tip_m - anchor_, w, params_.law.resolution_m)
                      : GuardedStep(guard_, tip_m - anchor_, w, 0, tank_);
  if (factor < 1) {
    out.flags |= kGuardEngaged;
    w *= factor;
  }
  dvec3 to = anchor_ + w;
  material.AnchorMoved(anchor_, to);
  anchor_ = to;
  return w;
}

// While the bur turns the anchor gives way, so R = Kc (p - a) stays true; at a wall moving the
// anchor would cut the wall, so the output is clipped.
void Coupling::BoundMagnitude(const dvec3& tip_m, double bound_n, bool wall, Material& material,
                              CouplingOutput& out) noexcept {
  out.force_sent_n = out.force_computed_n;
  double magnitude = std::sqrt(Dot(out.force_computed_n, out.force_computed_n));
  if (!(magnitude > bound_n)) return;
  out.flags |= kPeakBounded;
  double keep = bound_n / magnitude;
  if (wall) {
    clipped_at_n_ = bound_n;
  } else {
    dvec3 e = tip_m - anchor_;
    dvec3 w = e * (1 - keep);
    for (int i = 0; i < params_.max_substeps; ++i) {
      double length = std::sqrt(Dot(w, w));
      if (length == 0) break;
      dvec3 step = length <= params_.max_step_m ? w : w * (params_.max_step_m / length);
      MoveAnchor(tip_m, step, material, out);
      w -= step;
      if (length <= params_.max_step_m) break;
    }
  }
  out.force_sent_n = out.force_computed_n * keep;
}

dvec3 Coupling::MoveRest(const dvec3& tip_m, const dvec3& w, CouplingOutput& out) noexcept {
  if (Dot(w, w) == 0) return w;
  guard_.kc_n_per_m = params_.law.kc_n_per_m * share_;
  // All that the spring surely loses flows into the tank; the work of the tick does not bound it.
  constexpr double kNoBound_j = 1e9;
  double s = GuardedStep(guard_, tip_m - rest_, w, kNoBound_j, tank_);
  if (s < 1) out.flags |= kGuardEngaged;
  dvec3 taken = w * s;
  rest_ += taken;
  return taken;
}

double Coupling::RunOutReach() const noexcept {
  constexpr double kRunOutCells = 0.7;  // with the count of that tick less than sqrt(3)
  const dvec3& cell = params_.law.resolution_m;
  double least = cell.x < cell.y ? cell.x : cell.y;
  const double reach = kRunOutCells * (least < cell.z ? least : cell.z);
  // Out of cells so fine stored force would run for seconds. 14 N/s is 14 mN a millisecond.
  constexpr double kLeastRunOut_n_per_s = 14;
  const double least_m = kLeastRunOut_n_per_s * params_.law.tick_s / params_.law.kc_n_per_m;
  return reach < least_m ? least_m : reach;
}

// Where the bur does not go along, because it is at the tip already, force is not spent on cutting: it
// runs out.
// `spent_m` of it has run out in this tick already.
dvec3 Coupling::NoFasterThan(const dvec3& front, const dvec3& tip_moved, const dvec3& w,
                             double spent_m) const noexcept {
  double length = std::sqrt(Dot(w, w));
  if (!(length > 0)) return w;
  double along = Dot(front, w) / length, grown = Dot(tip_moved, w) / length;
  double free = (grown > 0 ? grown : 0) + RunOutReach() - spent_m;
  double reach = (along > 0 ? along : 0) + (free > 0 ? free : 0);
  return length <= reach ? w : w * (reach / length);
}

// The step w of the rest point, no longer than stored force may run out in a tick with nothing ahead
// (header comment), less `spent_m`.
dvec3 Coupling::RunOut(const dvec3& w, const dvec3& e, const dvec3& tip_moved,
                       double spent_m) const noexcept {
  double reach = RunOutReach();
  // A tick with a count has its change of force from that; where a tick holds a count as a rule, from both.
  const double moved2 = Dot(tip_moved, tip_moved);
  if (moved2 > 0) {
    const double moved = std::sqrt(moved2);
    const double rest = reach > moved ? reach - moved : 0;
    reach = Dot(tip_moved, e) > 0 && moved > rest ? moved : rest;
  }
  reach = reach > spent_m ? reach - spent_m : 0;
  double length = std::sqrt(Dot(w, w));
  return length <= reach ? w : w * (reach / length);
}

// How far beyond the bur's own step the rest point's step went.
double Coupling::RanOut(const dvec3& taken, const dvec3& front) const noexcept {
  double length = std::sqrt(Dot(taken, taken));
  if (!(length > 0)) return 0;
  double along = Dot(front, taken) / length, beyond = along > 0 ? length - along : length;
  return beyond > 0 ? beyond : 0;
}

// What is left of the bur's way e to the tip after a tick in which the rest point did not move. Where tissue
// resists, the bur comes up to the rest point, at most as far as the tip: by the share `rate`/(1 + `rate`) of
// that way in uniform tissue, and less where tissue resists more.
dvec3 Coupling::LeftBehind(const Sym3& b, const dvec3& e, const dvec3& gap,
                           double rate) const noexcept {
  const double trace = b.Trace();
  const dvec3 held = b * SolveShifted(b, trace * kFree, e);
  if (!(Dot(gap, held) > 0)) return held;
  const dvec3 resisted = b * SolveShifted(b, trace * kFree, gap);
  const dvec3 step = resisted - b * SolveShifted(b, trace * rate, gap);
  const double along = Dot(step, held), reach = Dot(held, held);
  if (!(along > 0)) return held;
  return along < reach ? held - step : dvec3(0);
}

// The bur's step for a step of the rest point in time dt. B splits space into the directions that tissue
// resists and those that are free: in the free ones the bur goes to the tip. While it cuts it also closes
// up to the tip, within a tenth of a second or so: where rest point and bur have come apart, the cut ends up
// where the hand is.
dvec3 Coupling::FrontStep(const dvec3& tip_m, const Contact& contact, const dvec3& rest_step,
                          double dt_s) const noexcept {
  constexpr double kCloseUp_s = 0.07;
  const Sym3& b = contact.damping_n_s_per_m;
  dvec3 e = tip_m - anchor_;
  double trace = b.Trace();
  if (!(trace > 0)) return e;
  bool cuts = Dot(rest_step, rest_step) > 0;
  // No force holds a bur that the rest point has left behind: it comes up without one.
  if (!cuts) return e - LeftBehind(b, e, rest_ - anchor_, dt_s / (3 * kCloseUp_s));
  double shift = trace * (dt_s / (3 * kCloseUp_s));
  dvec3 held = b * SolveShifted(b, shift, e), step = b * SolveShifted(b, shift, rest_step);
  double along = Dot(step, held), reach = Dot(held, held);
  dvec3 out = e - held;
  if (along > 0) out += along < reach ? step : step * (reach / along);
  return out;
}

void Coupling::TickSlipping(const dvec3& tip_m, double bound_n, Material& material,
                            CouplingOutput& out) noexcept {
  const double kc = params_.law.kc_n_per_m;
  dvec3 tip_moved = tip_m - tip_;
  tip_ = tip_m;
  const Ahead ahead = ReadAhead(tip_m, tip_moved, material);
  Contact contact = RelaxRest(tip_m, tip_moved, ahead.way_out, material, out);
  if (!ahead.contact.damping_n_s_per_m.IsFinite()) out.flags |= kNonFiniteInput;
  if (out.flags & kNonFiniteInput) return;
  resisted_ = contact.damping_n_s_per_m.Trace();
  held_ -= held_ * (params_.law.tick_s / (kHeld_s + params_.law.tick_s));
  if (resisted_ > held_) held_ = resisted_;
  if (ahead.way_out) {
    LetGoAlong(tip_m, tip_moved, ahead, out);
  } else {
    AimRest(tip_m, ahead.elsewhere ? ahead.contact : contact, out);
  }
  dvec3 e = tip_m - rest_;
  out.force_computed_n = e * -kc;
  double magnitude = kc * std::sqrt(Dot(e, e));
  if (magnitude > bound_n) {
    out.flags |= kPeakBounded;
    MoveRest(tip_m, e * (1 - bound_n / magnitude), out);
    e = tip_m - rest_;
  }
  guard_.kc_n_per_m = kc;
  share_ = StiffnessShare(guard_, e, bound_n, share_, tank_);
  out.force_sent_n = e * (-kc * share_);
  out.tank_j = tank_.energy_j;
}

// Spends the tick's time: the rest point relaxes, the bur goes along, contact is read again after
// every max_step of the bur's way. Returns the contact that was read last.
Contact Coupling::RelaxRest(const dvec3& tip_m, const dvec3& tip_moved, bool ahead_is_free,
                            Material& material, CouplingOutput& out) noexcept {
  const double kc = params_.law.kc_n_per_m;
  double left_s = params_.law.tick_s, spent_m = 0;
  Contact contact;
  for (int i = 0; i < params_.max_substeps; ++i) {
    dvec3 e = tip_m - rest_, front_e = tip_m - anchor_;
    if (Dot(e, e) == 0 && Dot(front_e, front_e) == 0) return contact;
    contact = material.ContactAt(anchor_, Dot(e, e) > 0 ? e : front_e);
    if (!contact.damping_n_s_per_m.IsFinite()) {
      out.flags |= kNonFiniteInput;
      return contact;
    }
    const double trace = contact.damping_n_s_per_m.Trace();
    bool resisted = trace > 0;
    // A last graze gives way at once, but the force that more tissue has built up is not spent on it.
    if (trace < kWayOut * held_) ahead_is_free = true;
    dvec3 felt = resisted ? BeyondCoulomb(e, contact, kc) : e;
    dvec3 w = felt - law_->Relax(felt, contact.damping_n_s_per_m, left_s);
    if (!resisted) w = e;
    if (!resisted || ahead_is_free) w = RunOut(w, e, tip_moved, spent_m);
    // The bur's way to the tip may be another than the stretch's, and meet something else.
    const bool same_way = SameWay(e, front_e, 0.5);
    Contact at_front = same_way ? contact : material.ContactAt(anchor_, front_e);
    if (!at_front.damping_n_s_per_m.IsFinite()) {
      out.flags |= kNonFiniteInput;
      return contact;
    }
    dvec3 front = FrontStep(tip_m, at_front, w, left_s);
    const bool stopped = StopAt(contact.wall_normal, w);
    if (StopAt(at_front.wall_normal, front) || stopped) out.flags |= kWallContact;
    if (resisted && !ahead_is_free) w = NoFasterThan(front, tip_moved, w, spent_m);
    double length = std::sqrt(Dot(front, front));
    double limit =
        at_front.clearance_m > params_.max_step_m ? at_front.clearance_m : params_.max_step_m;
    double share = length <= limit ? 1 : limit / length;
    ++out.substeps;
    const dvec3 taken = MoveRest(tip_m, w * share, out);
    // What may run out is a tick's, however many steps the bur takes.
    spent_m += RanOut(taken, resisted && !ahead_is_free ? front * share : dvec3(0));
    if (length > 0) {
      dvec3 to = anchor_ + front * share;
      material.AnchorMoved(anchor_, to);
      anchor_ = to;
    }
    if (share == 1) {
      if (!contact.engaged) out.flags |= kFreeAir;
      return contact;
    }
    left_s -= left_s * share;
  }
  out.flags |= kSubstepLimit;
  return contact;
}

// What the hand moves into. Along the stretch the damping is read anyway; a hand that moves another way
// meets something else. It is on its way out where that is less than a share of what the stretch met in
// the last tick, along its speed as the law knows it, or along a count against the stretch: the law
// learns of a turn only later, and by then the bur must have let go.
Coupling::Ahead Coupling::ReadAhead(const dvec3& tip_m, const dvec3& tip_moved,
                                    Material& material) noexcept {
  const dvec3 e = tip_m - rest_, speed = law_->speed_m_per_s();
  Ahead out;
  auto Free = [&](const dvec3& way, const Contact& contact) {
    return 3 * Dot(way, contact.damping_n_s_per_m * way) <= kWayOut * resisted_ * Dot(way, way);
  };
  if (Dot(speed, speed) > 0 && !SameWay(e, speed, 0.9)) {
    out.elsewhere = true;
    out.speed_m_per_s = speed;
    // As far as the hand goes in a tick: how far a contact looks ahead is its cost.
    out.contact = material.ContactAt(anchor_, speed * params_.law.tick_s);
    out.way_out = Free(speed, out.contact);
  }
  if (out.way_out || !(Dot(tip_moved, e) < 0)) return out;
  const Contact back = material.ContactAt(anchor_, tip_moved);
  if (!Free(tip_moved, back)) return out;
  out.way_out = true;
  out.speed_m_per_s = tip_moved / params_.law.tick_s;
  out.contact = back;
  return out;
}

// Whatever the stretch presses on across the motion, no more of it is against the motion than what is
// ahead resists with.
void Coupling::LetGoAlong(const dvec3& tip_m, const dvec3& tip_moved, const Ahead& ahead,
                          CouplingOutput& out) noexcept {
  const Contact& c = ahead.contact;
  const dvec3& speed = ahead.speed_m_per_s;
  const double speed2 = Dot(speed, speed);
  double still = (c.coulomb_n > c.threshold_n ? c.coulomb_n : c.threshold_n) * std::sqrt(speed2);
  double allowed = (Dot(speed, c.damping_n_s_per_m * speed) + still) / params_.law.kc_n_per_m;
  double excess = Dot(tip_m - rest_, speed) - allowed;
  // The law learns of a turn axis by axis, and late. So force against its speed runs out as
  // elsewhere: dropped at once, it is a step of 0.7 N to a hand that had stopped.
  excess =
      LowerOf(excess, (std::sqrt(Dot(tip_moved, tip_moved)) + RunOutReach()) * std::sqrt(speed2));
  if (excess > 0) MoveRest(tip_m, speed * (excess / speed2), out);
}

void Coupling::AimRest(const dvec3& tip_m, const Contact& contact, CouplingOutput& out) noexcept {
  if (!(contact.damping_n_s_per_m.Trace() > 0)) return;
  dvec3 e = tip_m - rest_, felt = BeyondCoulomb(e, contact, params_.law.kc_n_per_m);
  MoveRest(tip_m, felt - law_->Aim(felt, contact.damping_n_s_per_m), out);
}

}  // namespace enamel::haptics
