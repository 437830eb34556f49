#include "common/haptics/turning.h"

#include <cmath>

namespace enamel::haptics {
namespace {

constexpr int kManyTicks = 1'000'000;
constexpr double kAllOfIt_j = 1e30;  // what a turn frees may pay for the next, without bound

double Length(const dvec3& v) noexcept { return std::sqrt(Dot(v, v)); }

GuardParams GuardOf(const TurningParams& params) noexcept {
  GuardParams guard;
  guard.kc_n_per_m = params.k_n_m_per_rad;
  guard.cell.ball_m = params.cell_rad;
  guard.delay_ticks = params.delay_ticks;
  return guard;
}

}  // namespace

dvec3 SineOfTurn(const Quat& to, const Quat& from) noexcept {
  const Quat q = to * from.Conjugate();
  return dvec3(q.x, q.y, q.z) * (2 * q.w);
}

dvec3 BoundedSineOfTurn(const Quat& to, const Quat& from, double most) noexcept {
  const dvec3 e = SineOfTurn(to, from);
  const double length = Length(e);
  return length > most ? e * (most / length) : e;
}

dvec3 ChordOfTurn(const Quat& to, const Quat& from) noexcept {
  const Quat q = to * from.Conjugate();
  return dvec3(q.x, q.y, q.z) * (q.w < 0 ? -2.0 : 2.0);
}

Quat TurnedBy(const dvec3& turn, const Quat& from) noexcept {
  return (Quat{0.5 * turn.x, 0.5 * turn.y, 0.5 * turn.z, 1} * from).Normalised();
}

Turning::Turning(const TurningParams& params) : params_(params), guard_(GuardOf(params)) {
  tank_.cap_j = kAllOfIt_j;
  tank_.inflow_share = 1;
}

void Turning::Reset(const Quat& device) noexcept {
  bur_ = device;
  chord_ = 0;
  felt_ = false;
  if (silent_ticks_ < kManyTicks) ++silent_ticks_;
}

// Bounded for the guard too, which has to know what is felt.
dvec3 Turning::Stretch(const Quat& device) const noexcept {
  return BoundedSineOfTurn(device, bur_, params_.peak_n_m / params_.k_n_m_per_rad);
}

bool Turning::CanResume(const Quat& device) const noexcept {
  const Quat q = device * bur_.Conjugate();
  const double grown = Length(ChordOfTurn(device, bur_)) - chord_;
  return grown <= 0 || grown <= params_.max_turn_rad * std::fabs(q.w);
}

void Turning::Resume(const Quat& device, TurnMaterial& material) noexcept {
  const Quat q = device * bur_.Conjugate();
  const dvec3 chord = ChordOfTurn(device, bur_);
  const double length = Length(chord), grown = length - chord_;
  if (grown > 0) {
    // The chord is 2 sin(theta/2): it grows by cos(theta/2) of the angle.
    bur_ = TurnedBy(chord * (grown / (length * std::fabs(q.w))), bur_);
    material.BurTurned(bur_, false);
  }
  chord_ = Length(ChordOfTurn(device, bur_));
  felt_ = false;
  silent_ticks_ = 1;
}

dvec3 Turning::Tick(const Quat& device, TurnMaterial& material) noexcept {
  tank_.BeginTick();
  tank_.energy_j = 0;
  turned_ = 0;
  Follow(device, material);
  if (!felt_) Meet(device, material);
  chord_ = Length(ChordOfTurn(device, bur_));
  if (!felt_) {
    if (silent_ticks_ < kManyTicks) ++silent_ticks_;
    return dvec3(0);
  }
  silent_ticks_ = 0;
  const dvec3 torque = Stretch(device) * -params_.k_n_m_per_rad;
  return std::isfinite(Dot(torque, torque)) ? torque : dvec3(0);
}

// The turn that the law asks for: all of the way where nothing is ahead; in tissue the stretch
// relaxes as B (B + K T I)^-1.
dvec3 Turning::Relaxed(const Quat& device, const TurnContact& contact, double dt_s) const noexcept {
  if (contact.damping_n_m_s.IsZero()) return ChordOfTurn(device, bur_);
  const dvec3 e = Stretch(device);
  const Sym3& b = contact.damping_n_m_s;
  return e - b * SolveShifted(b, params_.k_n_m_per_rad * dt_s, e);
}

void Turning::Follow(const Quat& device, TurnMaterial& material) noexcept {
  double left_s = params_.tick_s;
  for (int i = 0; i < kMaxTurns; ++i) {
    const dvec3 chord = ChordOfTurn(device, bur_);
    if (!(Dot(chord, chord) > 0)) return;
    const TurnContact contact = material.ContactAt(bur_, chord);
    dvec3 turn = Relaxed(device, contact, left_s);
    const double length = Length(turn);
    const double limit =
        contact.clear_rad > params_.max_turn_rad ? contact.clear_rad : params_.max_turn_rad;
    const bool whole = !(length > limit);
    if (!whole) turn *= limit / length;
    if (felt_) turn = Guarded(Stretch(device), turn);
    const double taken = Length(turn);
    if (!(taken > 0) || !std::isfinite(taken)) return;
    bur_ = TurnedBy(turn, bur_);
    material.BurTurned(bur_, taken > params_.max_turn_rad);
    if (whole) return;
    left_s -= left_s * (limit / length);
  }
}

// With delay the guard counts with the length of the tick's whole way: turns do not add up as
// vectors do, and no two orientations are farther apart than the way between them.
dvec3 Turning::Guarded(const dvec3& stretch, const dvec3& turn) noexcept {
  const double length = Length(turn);
  if (!(length > 0) || !std::isfinite(length)) return dvec3(0);
  tank_.moved_m = turn * (turned_ / length);
  const double before = tank_.energy_j;
  const double share = GuardedStep(guard_, stretch, turn, kAllOfIt_j, tank_);
  const double way = share * length;
  // TurnedBy goes 2 atan(way/2) > way (1 - way^2/12): the same share of what would flow in is sure.
  if (tank_.energy_j > before) {
    const double sure = 1 - way * way / 12;
    tank_.energy_j = sure > 0 ? before + sure * (tank_.energy_j - before) : before;
  }
  turned_ += way;
  return turn * share;
}

void Turning::Meet(const Quat& device, TurnMaterial& material) noexcept {
  if (silent_ticks_ < params_.delay_ticks) return;  // torque is still under way
  const double chord = Length(ChordOfTurn(device, bur_));
  if (!(chord <= params_.cell_rad) || !(chord <= params_.max_turn_rad)) return;
  bur_ = device;
  if (chord > 0) material.BurTurned(bur_, false);
  felt_ = true;
}

void Turning::VisitState(StateArchive& archive) { archive(bur_, chord_, felt_, silent_ticks_); }

}  // namespace enamel::haptics
