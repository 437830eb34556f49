#pragma once

#include "common/base/check.h"
#include "common/base/state_archive.h"
#include "common/haptics/guard.h"
#include "common/math/orientation.h"
#include "common/math/sym3.h"

// Torque on a six-axis device: a spring between the device's orientation and the bur's, which turns
// through tissue. It is the coupling's idea once more with angles for lengths, and passive by the
// same guard; the proof is in README.md, "Torque".
//
// With q = device * conj(bur), v its vector part and w its scalar, theta the angle between the two:
// the spring holds U = K (1 - cos theta) = 2 K |v|^2, and its gradient is the torque
// tau = 2 K w v = K sin(theta) n. A bound F on the torque makes it min(F, K sin theta) n.
//
// All: scene frame, SI units, real-time safe, only + - * / sqrt.
namespace enamel::haptics {

// n sin(theta): the gradient of 1 - cos(theta) for turning `to` on.
dvec3 SineOfTurn(const Quat& to, const Quat& from) noexcept;
// The same, no longer than `most`: the gradient of the potential that grows by min(most, sin theta)
// per radian. What is felt, over K.
dvec3 BoundedSineOfTurn(const Quat& to, const Quat& from, double most) noexcept;
// n 2 sin(theta/2), the shorter way round: the turn itself for small angles, never longer than it.
dvec3 ChordOfTurn(const Quat& to, const Quat& from) noexcept;
// Turned on by `turn`, small: really by 2 atan(|turn|/2), which is never more than |turn|.
Quat TurnedBy(const dvec3& turn_rad, const Quat& from) noexcept;

// The resistance to a turn of the bur about its tip.
struct TurnContact {
  // Of what the turn brings the bur into, N m s. Zero: nothing is ahead. A wall: very large.
  Sym3 damping_n_m_s;
  // The bur may turn by this before contact must be read again. 0: not known.
  double clear_rad = 0;
};

// The world the bur turns in. Real-time: both must be safe.
class TurnMaterial {
 public:
  virtual ~TurnMaterial() = default;
  // At that orientation, for a turn about `turn` (any length).
  virtual TurnContact ContactAt(const Quat& bur, const dvec3& turn_rad) noexcept = 0;
  // The bur has turned; a running one cuts. `far`: by more than max_turn_rad, through open air.
  virtual void BurTurned(const Quat& bur, bool far) noexcept = 0;
};

struct TurningParams {
  double k_n_m_per_rad = 0;
  double peak_n_m = 0;  // never exceeded; at least 2 k cell, or the bur could not follow in air
  double cell_rad = 0;  // largest angle between the true and the measured orientation
  double tick_s = 1e-3;
  int delay_ticks = 0;         // as the guard is to count with
  double max_turn_rad = 1e-3;  // before contact is read again (half a voxel at the bur's far end)
};

// Passive where k <= 2 b_rot / ((delay_ticks + 1)^2 tick_s) and the device's Coulomb torque is at
// least k cell_rad, whatever the hand, the tissue and the law do: the sum of
// tau.dphi + (b_rot/T) |dphi|^2 + c_rot |dphi| never falls under -(k/2) cell_rad^2 per time that
// the torque was switched on.
//
// Torque is switched on where device and bur meet: with Reset, and after a Resume once the hand has
// turned back to where the bur is. Until then it is 0 and the bur follows without it.
//
// Thread safety: none, one loop owns it. Real-time: all but VisitState are safe.
class Turning {
 public:
  static constexpr int kMaxTurns = 64;  // readings of contact in a tick

  explicit Turning(const TurningParams& params);

  // The bur's orientation is the device's; this tick sends no torque.
  void Reset(const Quat& device) noexcept;
  // After ticks that were not stepped. Whether the bur can follow by what the angle has grown with
  // a single turn of at most max_turn_rad; if not, Reset is all that is left.
  bool CanResume(const Quat& device) const noexcept;
  // Does so. The hand turned unseen and may have taken all that was in the spring, so the torque
  // stays off until the two meet. This tick sends none. Requires: CanResume.
  void Resume(const Quat& device, TurnMaterial& material) noexcept;
  // One tick. Torque on the operator, N m. What is not finite turns nothing and gives no torque.
  ENAMEL_REALTIME dvec3 Tick(const Quat& device, TurnMaterial& material) noexcept;

  const Quat& bur() const noexcept { return bur_; }
  // The torque is on: what is felt is the spring's.
  bool felt() const noexcept { return felt_; }
  // Saves or restores all that the next Tick depends on but the parameters. Not real-time.
  void VisitState(StateArchive& archive);

 private:
  dvec3 Stretch(const Quat& device) const noexcept;  // the torque over K
  dvec3 Relaxed(const Quat& device, const TurnContact& contact, double dt_s) const noexcept;
  void Follow(const Quat& device, TurnMaterial& material) noexcept;
  dvec3 Guarded(const dvec3& stretch, const dvec3& turn) noexcept;
  void Meet(const Quat& device, TurnMaterial& material) noexcept;

  const TurningParams params_;
  const GuardParams guard_;
  Quat bur_;
  double chord_ = 0;  // between device and bur after the last tick
  bool felt_ = false;
  int silent_ticks_ = 0;  // in a row without torque
  // Of this tick. What an early turn is certain to have taken from the spring may pay for a later
  // one; nothing is carried into the next tick.
  Tank tank_;
  double turned_ = 0;
};

}  // namespace enamel::haptics
