#pragma once

#include <cstdint>
#include <memory>

#include "common/base/check.h"
#include "common/board/spring.h"
#include "common/haptics/force_law.h"
#include "common/haptics/friction_relief.h"
#include "common/haptics/guard.h"
#include "common/haptics/swing_watch.h"
#include "common/math/feed_force.h"

// The tick's force chain: finite check -> law -> stiffness -> guard -> magnitude bound -> push -> finite check.
//
// Two points: the bur a, which is drawn and cuts, and the rest point r of the spring that makes the
// force, R = Kc (p - r) while all of the stiffness is felt.
//  * The law says how hard the bur is pulled, and the bur goes through tissue as that pull over B.
//    Where nothing resists it is at the tip in the same tick. No bound and no guard holds it.
//  * r goes to where the spring gives the law's pull less the device's own friction, by guarded steps
//    (guard.h). The proof is in README.md, "Why it is passive", and rests on that alone: the operator
//    never extracts energy, whatever the tissue, the geometry, B(t), the law's parameters, a guessed
//    friction or the hand do.
//  * Where the unit's friction was measured, the motors push along the motion with what the cell leaves of it, and
//    the spring is softer in soft tissue (friction_relief.h). Then the proof rests on the measured c, too.
//  * In tissue that is cut by load the bur goes where the secant B of the feed before leads, and so far that
//    the pull along that way is the cutting force at that feed (FeedUnder). In a steady cut both are
//    exact. The friction of the turning surface is in the wish alone: the guard pays for it, or refuses.
//  * A bound on the force moves r, at a wall too, never the bur.
//  * A swing of hand and device lowers Kc, in law, spring and guard alike (swing_watch.h; in the law alone
//    where a board runs the spring): R = B v of the bur stays true, only softer. The share that is taken away is energy lost, so the proof holds.
//  * After ticks that were not stepped, Resume lets the spring be no longer than the tank pays for.
// The tip laws (eq. 1, eq. 17) have no anchor and no such proof: they are there to be compared with.
namespace enamel::haptics {

// What the bur touches, read at the anchor's pose.
struct Contact {
  Sym3 damping_n_s_per_m;  // B of what the bur's engaged surface cuts; zero in air
  bool engaged = false;    // any part of the bur within reach of solid, in the direction of travel
  // A still bur or the shank against solid: motion along +wall_normal (into the material) is
  // blocked, everything else is free. Zero when there is no wall.
  dvec3 wall_normal{0};
  // How far the bur may travel in a straight line before it can touch anything else, m. Zero when
  // not known; lets a step through open air be taken at once.
  double clearance_m = 0;
  // The tissue is cut by load: the force is no B v. The Material's functions below say what it is.
  bool by_load = false;
};

// The world the coupling moves in. Implemented by the core (volume and bur), by the qualification
// suite (constant or random B) and by tests. Real-time: both methods must be safe.
class Material {
 public:
  virtual ~Material() = default;
  // Contact at the anchor for travel along `stretch_m` = p - a (metres, not normalised).
  virtual Contact ContactAt(const dvec3& anchor_m, const dvec3& stretch_m) noexcept = 0;
  // The anchor moved in a straight line; a turning bur cuts along it.
  virtual void AnchorMoved(const dvec3& from_m, const dvec3& to_m) noexcept = 0;
  // After a ContactAt that says by_load, of what it found. Secant: the B with which B v is the force at that feed,
  // never without bound. Along: in a direction of length 1. Drag: what the turning surface adds at that feed, as a force
  // that the hand is to resist; it does work that the spindle pays.
  virtual Sym3 SecantAt(const dvec3& feed_m_per_s) noexcept {
    (void)feed_m_per_s;
    return {};
  }
  virtual FeedForce ForceAlong(const dvec3& direction) noexcept {
    (void)direction;
    return {};
  }
  virtual dvec3 DragAt(const dvec3& feed_m_per_s) noexcept {
    (void)feed_m_per_s;
    return dvec3(0);
  }
};

// Which bounds engaged in a tick; recorded with it.
enum CouplingFlags : uint16_t {
  kGuardEngaged = 1 << 0,    // the guard shortened a step of the rest point
  kPeakBounded = 1 << 1,     // the magnitude bound held the force down
  kNonFiniteInput = 1 << 2,  // position or material was NaN or infinite: force 0, anchor kept
  kSubstepLimit = 1 << 3,    // the anchor could not reach its place within the bounded work
  kWallContact = 1 << 4,
  kFreeAir = 1 << 5,  // nothing engaged in the direction of travel
  kLatched = 1 << 6,  // after kNonFiniteInput: force 0 and anchor kept until Reset
};

struct CouplingParams {
  LawParams law;
  double peak_force_n = 0;    // magnitude never exceeded, N
  double max_step_m = 25e-6;  // longest anchor move before contact is read again (half a voxel)
  int max_substeps = 96;      // bound on work per tick
  int delay_ticks = 0;        // whole ticks from reading to force, as the guard is to count with
  // Where the true tip can be around the measured one; of no size: the law's resolution per axis.
  TipCell cell{};
  OwnFriction friction{};  // anchored laws
  // The device's board runs spring and guard (common/board/board.h). The coupling says where the rest
  // point should be, and feels the spring that the board reports.
  bool spring_on_board = false;
  // Anchored laws: a swing lowers the stiffness until the coupling is destroyed. Off where the
  // lab judges a law alone.
  bool watch_swings = false;
};

struct CouplingOutput {
  // On the operator, world frame. Computed: what the hand is to feel, before the bounds, the device's
  // own friction among it. Sent: to the motors, after the bounds, without that friction.
  dvec3 force_computed_n{0};
  dvec3 force_sent_n{0};
  dvec3 push_n{0};  // of force_sent_n: what pushes along the motion (FrictionRelief)
  dvec3 anchor_m{0};
  uint16_t flags = 0;  // CouplingFlags
  uint16_t substeps = 0;
  double tank_j = 0;  // energy in the tank after the tick, J (anchored laws)
  // Where the law wants the rest point, and whether nothing solid is near, so that a board may keep
  // it at the tip by itself (anchored laws).
  dvec3 wish_m{0};
  bool follow = false;
};

// Thread safety: none, one loop owns it. Real-time: Tick and Reset are safe (no allocation).
class Coupling {
 public:
  explicit Coupling(const CouplingParams& params);

  // Anchor at the tip, no force, law's history cleared, latched fault cleared: start of an attempt,
  // after a gap or fault.
  void Reset(const dvec3& tip_m) noexcept;
  // After ticks that were not stepped: the hand moved while no force was sent, and may have taken all
  // that was in the spring. So the rest point goes to the tip but for what the tank pays (ResumedShare).
  // The bur follows by what its way to the tip has grown, if that is at most max_step (a cut of the same
  // length); the law's history is cleared. With delay, call it only once the forces under way have ended.
  // The next Tick may follow in the same tick of the device. False, and nothing done, when the way has
  // grown by more or a fault is latched: Reset is all that is left.
  [[nodiscard]] bool Resume(const dvec3& tip_m, Material& material) noexcept;
  // Before Tick, if the spring is on the board: its rest point and share at the reading.
  ENAMEL_REALTIME void TakeSpring(const dvec3& rest_m, double share) noexcept;
  // One tick. `bound_ratio` in [0, 1] scales the peak bound (fault fade). What is not finite, in or
  // out, gives no force, and none until Reset: a fault latches until somebody acts.
  ENAMEL_REALTIME CouplingOutput Tick(const dvec3& tip_m, double bound_ratio,
                                      Material& material) noexcept;

  // Saves or restores all that the next Tick depends on but the parameters. Not real-time.
  void VisitState(StateArchive& archive);

  // The bur.
  const dvec3& anchor_m() const noexcept { return anchor_; }
  // Where the spring is at rest, and what is in the tank: V + E of the proof.
  dvec3 rest_m() const noexcept { return law_->anchored() ? FromBoard(spring_.rest_m) : anchor_; }
  double tank_j() const noexcept { return spring_.tank.energy_j; }
  // The share of Kc that a swing has left, in [SwingWatch::kMinShare, 1]. Stays through Reset.
  double stiffness_share() const noexcept { return watch_.share(); }
  // The stiffness that the hand feels: Kc less the shares that a swing, soft tissue and a bound take.
  double stiffness_n_per_m() const noexcept { return spring_.guard.kc_n_per_m * spring_.share; }
  const CouplingParams& params() const noexcept { return params_; }

 private:
  // The law's pull at the end of a tick, and the damping that the tissue has along it.
  struct Resistance {
    dvec3 pull_n{0};
    double b_n_s_per_m = 0;
  };
  Resistance RelaxAnchor(const dvec3& tip_m, Material& material, CouplingOutput& out) noexcept;
  dvec3 StepByLoad(const Pull& pull, const dvec3& way, double dt_s, Material& material) noexcept;
  void SendThroughSpring(const dvec3& tip_m, const Resistance& resistance, double bound_n,
                         CouplingOutput& out) noexcept;
  void PullSpring(const dvec3& tip_m, const dvec3& wish_m, double bound_n,
                  CouplingOutput& out) noexcept;
  void TickTip(const dvec3& tip_m, double bound_n, Material& material,
               CouplingOutput& out) noexcept;
  void MoveBur(const dvec3& to_m, Material& material) noexcept;
  // Both shares of the stiffness.
  double share() const noexcept { return watch_.share() * relief_.share(); }
  void SetStiffness() noexcept;
  void FollowTissue(const dvec3& tip_m, double b_n_s_per_m) noexcept;

  CouplingParams params_;
  std::unique_ptr<ForceLaw> law_;
  dvec3 anchor_{0};  // the bur
  dvec3 feed_{0};    // its speed in the last step through tissue that is cut by load, m/s; else 0
  EnSpring spring_{};
  SwingWatch watch_;
  FrictionRelief relief_;
  double stretch_ = 0;  // |tip - anchor| after the last tick
  bool clear_ = false;  // nothing solid is near the bur
  bool resumed_ = false;
  bool latched_ = false;
};

}  // namespace enamel::haptics
