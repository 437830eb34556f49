#include "common/haptics/coupling.h"

#include <cmath>

namespace enamel::haptics {
namespace {

bool Finite(const dvec3& v) noexcept {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

}  // namespace

double GuardFactor(const dvec3& e, const dvec3& w, const dvec3& delta) noexcept {
  double w2 = Dot(w, w);
  if (!(w2 > 0)) return 0;
  double cell = 0.5 * (delta.x * std::fabs(w.x) + delta.y * std::fabs(w.y) + delta.z * std::fabs(w.z));
  double factor = 2 * (Dot(e, w) - cell) / w2;
  if (!(factor > 0)) return 0;
  return factor < 1 ? factor : 1;
}

Coupling::Coupling(const CouplingParams& params) : params_(params) {
  const LawEntry* entry = FindLaw(params.law.kind);
  ENAMEL_CHECK(entry != nullptr);
  law_ = entry->make(params.law);
}

void Coupling::Reset(const dvec3& tip_m) noexcept {
  anchor_ = tip_m;
  stretch_ = 0;
  clipped_at_n_ = 0;
  wall_ = false;
  latched_ = false;
  law_->Reset(tip_m);
}

void Coupling::VisitState(StateArchive& archive) {
  archive(anchor_, stretch_, clipped_at_n_, wall_, latched_);
  law_->VisitState(archive);
}

bool Coupling::Resume(const dvec3& tip_m, Material& material) noexcept {
  if (latched_ || !Finite(tip_m)) return false;
  dvec3 e = tip_m - anchor_;
  double length = std::sqrt(Dot(e, e)), grown = length - stretch_;
  if (grown > params_.max_step_m) return false;
  law_->Reset(tip_m);
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
  if (clipped_at_n_ > 0 && bound_n > clipped_at_n_) bound_n = clipped_at_n_;
  clipped_at_n_ = 0;
  law_->BeginTick(tip_m);
  wall_ = false;
  if (law_->anchored()) {
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
// max_step, so an air step stops at the first contact and the rest of the tick is spent in the
// material found there; a layer boundary likewise.
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
    double step_limit = contact.clearance_m > params_.max_step_m ? contact.clearance_m : params_.max_step_m;
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

dvec3 Coupling::MoveAnchor(const dvec3& tip_m, dvec3 w, Material& material, CouplingOutput& out) noexcept {
  if (Dot(w, w) == 0) return dvec3(0);
  double factor = GuardFactor(tip_m - anchor_, w, params_.law.resolution_m);
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

}  // namespace enamel::haptics
