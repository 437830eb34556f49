#include "common/haptics/coupling.h"

#include <cmath>
#include <limits>

#include "common/haptics/wall.h"

namespace enamel::haptics {
namespace {

bool Finite(const dvec3& v) noexcept {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

// All that the spring surely loses may flow into the tank: the work of the tick does not bound it.
constexpr double kNoBound_j = 1e9;

double DampingAlong(const Sym3& b, const dvec3& way) noexcept {
  const double length2 = Dot(way, way);
  return length2 > 0 ? Dot(way, b * way) / length2 : 0;
}

// Tissue that is cut by load resists a slow bur more than a wall does, but it is no wall: this bounds the B that the law
// gets. The pull of a law may fall towards a wall. It would then slow a slow bur further, and hand and device would swing.
Sym3 NoWall(const Sym3& b, const dvec3& way) noexcept {
  const double along = DampingAlong(b, way);
  return along > kWall_n_s_per_m ? b * (kWall_n_s_per_m / along) : b;
}

TipCell CellOf(const CouplingParams& p) noexcept {
  return p.cell.Radius() > 0 ? p.cell : CartesianCell(p.law.resolution_m);
}

}  // namespace

Coupling::Coupling(const CouplingParams& params)
    : params_(params),
      watch_({.tick_s = params.law.tick_s}),
      // A spring that rises while forces are under way, or that a board runs, is not in the proof.
      relief_(params.friction, params.law.kc_n_per_m, params.law.tick_s, CellOf(params).Radius(),
              params.delay_ticks == 0 && !params.spring_on_board) {
  const TipCell cell = CellOf(params);
  params_.law.play_m = 2 * cell.Radius();
  const LawEntry* entry = FindLaw(params.law.kind);
  ENAMEL_CHECK(entry != nullptr);
  law_ = entry->make(params_.law);
  // Enough to turn half of the peak force around; empty at the start, so that the floor is -V_0.
  double half = 0.5 * params.peak_force_n;
  spring_.tank.cap_j = params.law.kc_n_per_m > 0 ? 0.5 * half * half / params.law.kc_n_per_m : 0;
  spring_.tank.inflow_share = 1;
  spring_.share = 1;
  spring_.guard = GuardParams{params.law.kc_n_per_m, cell, params.delay_ticks}.board();
}

void Coupling::Reset(const dvec3& tip_m) noexcept {
  anchor_ = tip_m;
  EnSpringReset(&spring_, ToBoard(tip_m));
  stretch_ = 0;
  feed_ = dvec3(0);
  clear_ = resumed_ = latched_ = false;
  watch_.Forget();
  relief_.Reset();
  SetStiffness();
  law_->Reset(tip_m);
}

void Coupling::VisitState(StateArchive& archive) {
  archive(anchor_, feed_, spring_, stretch_, clear_, resumed_, latched_);
  watch_.VisitState(archive);
  relief_.VisitState(archive);
  law_->VisitState(archive);
}

void Coupling::TakeSpring(const dvec3& rest_m, double share) noexcept {
  spring_.rest_m = ToBoard(rest_m);
  spring_.share = share;
}

bool Coupling::Resume(const dvec3& tip_m, Material& material) noexcept {
  if (latched_ || !Finite(tip_m)) return false;
  const dvec3 e = tip_m - anchor_;
  const double length = std::sqrt(Dot(e, e)), grown = length - stretch_;
  if (grown > params_.max_step_m) return false;
  watch_.Forget();
  relief_.Forget();
  law_->Reset(tip_m);
  if (law_->anchored()) {
    // A board's spring has gone on by itself.
    if (!params_.spring_on_board) EnSpringResume(&spring_, ToBoard(tip_m));
    resumed_ = true;
    if (grown > 0) MoveBur(anchor_ + e * (grown / length), material);
  } else if (grown > 0) {
    MoveBur(tip_m, material);
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
  const double bound_n = params_.peak_force_n * (bound_ratio < 0   ? 0
                                                 : bound_ratio > 1 ? 1
                                                                   : bound_ratio);
  law_->BeginTick(tip_m);
  if (law_->anchored()) {
    // A tick's first one is Resume where there was a gap: its move counts with the tick's.
    if (!resumed_) EnBeginTick(&spring_.tank);
    resumed_ = false;
    const Resistance resistance = RelaxAnchor(tip_m, material, out);
    if ((out.flags & kNonFiniteInput) == 0) SendThroughSpring(tip_m, resistance, bound_n, out);
  } else {
    TickTip(tip_m, bound_n, material, out);
  }
  if (!Finite(out.force_sent_n) || !Finite(out.force_computed_n)) out.flags |= kNonFiniteInput;
  if (out.flags & kNonFiniteInput) {
    latched_ = true;
    out.flags |= kLatched;
    out.force_computed_n = out.force_sent_n = dvec3(0);
  }
  const dvec3 stretch = tip_m - anchor_;
  stretch_ = std::sqrt(Dot(stretch, stretch));
  out.anchor_m = anchor_;
  return out;
}

// Spends the tick's time T moving the bur toward the tip. Contact is read again after every max_step.
// So an air step stops at the first contact, or a step at a layer boundary, and the rest of the tick is
// spent in the material found there. Returns R as the law wants it after the last step.
//
// In time dt a pull K s moves the bur by w with B w = K (s - w) dt (implicit): s - w = B (B + K dt)^-1 s,
// defined for every B >= 0. B = 0 gives w = s (air), B -> infinity gives w = 0 (a wall of stiffness K).
// Then R = K (s - w) = B w/dt exactly: eq. 1 for the bur that cuts.
Coupling::Resistance Coupling::RelaxAnchor(const dvec3& tip_m, Material& material,
                                           CouplingOutput& out) noexcept {
  double left_s = params_.law.tick_s;
  for (int i = 0; i < params_.max_substeps; ++i) {
    const dvec3 e = tip_m - anchor_;
    if (Dot(e, e) == 0) return {};
    const Contact contact = material.ContactAt(anchor_, e);
    const Sym3 b = contact.by_load ? material.SecantAt(feed_) : contact.damping_n_s_per_m;
    if (!b.IsFinite()) {
      out.flags |= kNonFiniteInput;
      return {};
    }
    clear_ = !contact.engaged && contact.clearance_m > 0;
    Pull pull{e, params_.law.kc_n_per_m * share()};
    double along = 0;
    dvec3 step = e;
    if (b.Trace() > 0) {
      pull = law_->PullOn(anchor_, contact.by_load ? NoWall(b, e) : b);
      pull.stiffness_n_per_m *= share();
      along = DampingAlong(b, pull.stretch_m);
      const double shift = pull.stiffness_n_per_m * left_s;
      step = shift > 0 ? pull.stretch_m - b * SolveShifted(b, shift, pull.stretch_m) : dvec3(0);
      if (contact.by_load) step = StepByLoad(pull, step, left_s, material);
    } else {
      law_->PassAir();
    }
    const double into = Dot(step, contact.wall_normal);
    if (into > 0) {
      step -= contact.wall_normal * into;
      along = std::numeric_limits<double>::infinity();
      out.flags |= kWallContact;
    }
    feed_ = contact.by_load ? step / left_s : dvec3(0);
    const double length = std::sqrt(Dot(step, step));
    const double limit =
        contact.clearance_m > params_.max_step_m ? contact.clearance_m : params_.max_step_m;
    const double share = length <= limit ? 1 : limit / length;
    ++out.substeps;
    if (length > 0) MoveBur(anchor_ + step * share, material);
    if (share == 1 || i + 1 == params_.max_substeps) {
      if (share < 1) {
        out.flags |= kSubstepLimit;
      } else if (!contact.engaged) {
        out.flags |= kFreeAir;
      }
      const dvec3 drag_n = contact.by_load ? material.DragAt(feed_) : dvec3(0);
      return {(pull.stretch_m - step * share) * pull.stiffness_n_per_m + drag_n, along};
    }
    left_s -= left_s * share;
  }
  return {};
}

// The way that the secant of the feed before has found, at the length that this tick's pull and the cutting force give.
dvec3 Coupling::StepByLoad(const Pull& pull, const dvec3& way, double dt_s,
                           Material& material) noexcept {
  const double length = std::sqrt(Dot(way, way));
  if (!(length > 0)) return dvec3(0);
  const dvec3 direction = way / length;
  return direction * FeedUnder(pull.stiffness_n_per_m, Dot(pull.stretch_m, direction), dt_s,
                               material.ForceAlong(direction));
}

// Moves the rest point to where the spring would give the pull less the device's friction, as far as the
// guard lets it, and sends what the spring gives. A bound lets the rest point give way, at a wall too; what
// is left of it is a share of the stiffness.
void Coupling::SendThroughSpring(const dvec3& tip_m, const Resistance& resistance, double bound_n,
                                 CouplingOutput& out) noexcept {
  const double b = resistance.b_n_s_per_m;
  // Where the tip is exactly at the bur, nobody knows the tissue.
  const bool resists = Dot(resistance.pull_n, resistance.pull_n) > 0;
  if (resists || (out.flags & kFreeAir)) FollowTissue(tip_m, b);
  SetStiffness();
  // A board's spring has the profile's stiffness.
  const double kc = params_.spring_on_board ? params_.law.kc_n_per_m : spring_.guard.kc_n_per_m;
  const dvec3 pull_n = LessFriction(resistance.pull_n, b, params_.law.kc_n_per_m, params_.friction);
  const double magnitude = std::sqrt(Dot(pull_n, pull_n));
  double keep = 1;
  if (magnitude > bound_n) {
    out.flags |= kPeakBounded;
    keep = bound_n / magnitude;
  }
  out.wish_m = kc > 0 ? tip_m - pull_n * (keep / kc) : rest_m();
  out.follow = clear_;
  if (params_.spring_on_board) {
    out.force_computed_n = (tip_m - rest_m()) * -kc;
    out.force_sent_n = out.force_computed_n * spring_.share;
    if (spring_.share < 1) out.flags |= kPeakBounded;
  } else {
    PullSpring(tip_m, out.wish_m, bound_n, out);
  }
  out.force_computed_n -= resistance.pull_n - pull_n;
  // The watch looks at the spring alone: a push that turns with the hand is no swing.
  if (params_.watch_swings && Finite(out.force_sent_n)) watch_.Tick(out.force_sent_n);
  // A swing says that the profile is wrong, and its friction may be. A bound leaves no room.
  if (!params_.spring_on_board && !watch_.tripped() && !(out.flags & kPeakBounded)) {
    const dvec3 push_n = relief_.Push(resistance.pull_n, b, kc), sent_n = out.force_sent_n + push_n;
    if (Dot(sent_n, sent_n) <= bound_n * bound_n) {
      out.force_sent_n = sent_n;
      out.push_n = push_n;
    }
  }
}

// Makes the spring as stiff as the tissue needs, before it pulls: the tank pays at the tip that was read now, since the
// last tick's force was of the last stiffness. On a rise the rest point follows first, so that the stiffer spring pulls no
// harder. The energy that the softer one loses by that pays for the rise: (R^2/2) (1/K - 1/K'), but for the cell.
void Coupling::FollowTissue(const dvec3& tip_m, double b) noexcept {
  const double next = relief_.NextShare(b), radius_m = 0.5 * params_.law.play_m;
  if (next == relief_.share()) return;
  dvec3 stretch = tip_m - rest_m();
  if (next > relief_.share() && Dot(stretch, stretch) > radius_m * radius_m) {
    EnGuard felt = spring_.guard;
    felt.kc_n_per_m *= spring_.share;
    const dvec3 way = stretch * (1 - relief_.share() / next);
    const double share =
        EnGuardedStep(&felt, ToBoard(stretch), ToBoard(way), kNoBound_j, &spring_.tank);
    spring_.rest_m = ToBoard(rest_m() + way * share);
    stretch = tip_m - rest_m();
  }
  relief_.TakeShare(next, std::sqrt(Dot(stretch, stretch)), &spring_.tank);
}

void Coupling::PullSpring(const dvec3& tip_m, const dvec3& wish_m, double bound_n,
                          CouplingOutput& out) noexcept {
  const EnForce force = EnSpringPull(&spring_, ToBoard(tip_m), ToBoard(wish_m), bound_n, 1);
  if (force.flags & kEnGuarded) out.flags |= kGuardEngaged;
  if ((force.flags & kEnBounded) || spring_.share < 1) out.flags |= kPeakBounded;
  out.force_computed_n = FromBoard(force.whole_n);
  out.force_sent_n = FromBoard(force.felt_n);
  out.tank_j = spring_.tank.energy_j;
}

// The laws without an anchor: the bur is at the tip, and the output is clipped.
void Coupling::TickTip(const dvec3& tip_m, double bound_n, Material& material,
                       CouplingOutput& out) noexcept {
  const Contact contact = material.ContactAt(tip_m, tip_m - anchor_);
  if (!contact.damping_n_s_per_m.IsFinite()) out.flags |= kNonFiniteInput;
  out.force_computed_n = out.force_sent_n = -law_->TipForce(contact.damping_n_s_per_m);
  MoveBur(tip_m, material);
  if (!contact.engaged) out.flags |= kFreeAir;
  const double magnitude = std::sqrt(Dot(out.force_computed_n, out.force_computed_n));
  if (!(magnitude > bound_n)) return;
  out.flags |= kPeakBounded;
  out.force_sent_n = out.force_computed_n * (bound_n / magnitude);
}

// A guard of less than the profile's Kc asks for less damping and friction.
void Coupling::SetStiffness() noexcept {
  spring_.guard.kc_n_per_m = params_.law.kc_n_per_m * share();
}

void Coupling::MoveBur(const dvec3& to_m, Material& material) noexcept {
  material.AnchorMoved(anchor_, to_m);
  anchor_ = to_m;
}

}  // namespace enamel::haptics
